// SPDX-License-Identifier: Apache-2.0
// The window: GLFW and Dear ImGui. With --frames-to-draw it closes by itself, for tests.
#include <epoxy/gl.h>
// After GL's functions.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "runtime/viewer/imgui_headers.h"
#include "runtime/viewer/light_bench.h"
#include "runtime/viewer/show.h"

namespace photic::viewer {
namespace {

/// GLFW, the window and ImGui, in the order in which they are made; taken down in the reverse.
class Window {
public:
    Window(int width, int height) {
        glfwSetErrorCallback([](int, const char* text) { last_error_ = text; });
        if (!glfwInit()) refuse();
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        window_ = glfwCreateWindow(width, height, "photic view", nullptr, nullptr);
        if (!window_) {
            glfwTerminate();
            refuse();
        }
        glfwMakeContextCurrent(window_);
        glfwSwapInterval(1);
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;  // no file left behind
        ImGui_ImplGlfw_InitForOpenGL(window_, true);
        ImGui_ImplOpenGL3_Init("#version 430 core");
    }
    ~Window() {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
        glfwDestroyWindow(window_);
        glfwTerminate();
    }
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    GLFWwindow* handle() const { return window_; }

private:
    [[noreturn]] static void refuse() {
        throwFailure("window", "there is no screen to open a window of OpenGL 4.3 on (" + last_error_ +
                                   "); --screenshot out.png draws without one");
    }
    static inline std::string last_error_ = "GLFW gives no reason";
    GLFWwindow* window_ = nullptr;
};

void orbit(Camera& camera, const ImVec2& pixels) {
    const glm::vec3 from = camera.eye - camera.target;
    const float distance = glm::length(from);
    const float azimuth = std::atan2(from.y, from.x) - 0.006f * pixels.x;
    const float height = std::clamp(std::asin(from.z / distance) + 0.006f * pixels.y, -1.54f, 1.54f);
    camera.eye = camera.target + distance * glm::vec3(std::cos(height) * std::cos(azimuth),
                                                      std::cos(height) * std::sin(azimuth), std::sin(height));
}

/// What a movement of the mouse is in the world, at a distance from the eye [m].
glm::vec3 inWorld(const Camera& camera, const ImVec2& pixels, float distance) {
    const glm::vec3 forward = glm::normalize(camera.target - camera.eye);
    const glm::vec3 right = glm::normalize(glm::cross(forward, glm::vec3(0, 0, 1))), up = glm::cross(right, forward);
    const float metres =
        2 * distance * std::tan(glm::radians(camera.field_of_view_deg) / 2) / ImGui::GetIO().DisplaySize.y;
    return metres * (pixels.x * right - pixels.y * up);
}

/// Azimuth and height above the horizon [degrees] of where a light comes from.
glm::dvec2 anglesOf(const glm::dvec3& direction) {
    return glm::degrees(
        glm::dvec2(std::atan2(-direction.y, -direction.x), std::asin(std::clamp(-direction.z, -1.0, 1.0))));
}

glm::dvec3 directionOf(const glm::dvec2& degrees) {
    const glm::dvec2 a = glm::radians(degrees);
    return -glm::dvec3(std::cos(a.y) * std::cos(a.x), std::cos(a.y) * std::sin(a.x), std::sin(a.y));
}

/// With Ctrl the mouse moves a lamp across the view, and turns a sun.
void dragLight(LightBench& bench, const Camera& camera, const ImVec2& pixels) {
    if (bench.lights().empty() || (pixels.x == 0 && pixels.y == 0)) return;
    const Light& light = bench.lights()[bench.chosen()];
    if (light.position) {
        const glm::dvec3 by = inWorld(camera, pixels, glm::length(camera.eye - glm::vec3(*light.position)));
        bench.moveTo(*light.position + by, light.direction);
    } else {
        glm::dvec2 angles = anglesOf(light.direction);
        angles.x -= 0.2 * static_cast<double>(pixels.x);
        angles.y = std::clamp(angles.y - 0.2 * static_cast<double>(pixels.y), -89.0, 89.0);
        bench.moveTo({}, directionOf(angles));
    }
}

void followMouse(Picture& picture, const Stage& stage, LightBench* bench) {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantCaptureMouse) return;
    Camera& camera = picture.camera;
    if (bench && io.KeyCtrl && ImGui::IsMouseDown(ImGuiMouseButton_Left))
        return dragLight(*bench, camera, io.MouseDelta);
    if (io.MouseWheel != 0) camera.eye = camera.target + std::pow(0.9f, io.MouseWheel) * (camera.eye - camera.target);
    const bool shift = io.KeyShift || ImGui::IsMouseDown(ImGuiMouseButton_Middle);
    if (shift && (ImGui::IsMouseDown(ImGuiMouseButton_Left) || ImGui::IsMouseDown(ImGuiMouseButton_Middle))) {
        const glm::vec3 by = inWorld(camera, io.MouseDelta, glm::length(camera.eye - camera.target));
        camera.eye -= by, camera.target -= by;
    } else if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
        orbit(camera, io.MouseDelta);
    } else if (ImGui::IsMouseDown(ImGuiMouseButton_Right)) {
        if (picture.ball_radius <= 0) picture.ball_radius = 0.08f * glm::length(stage.max - stage.min);
        picture.ball_centre += inWorld(camera, io.MouseDelta, glm::length(camera.eye - picture.ball_centre));
    }
}

bool chooseSource(const char* label, Source& source, const Renderer& renderer) {
    bool changed = false;
    if (!ImGui::BeginCombo(label, kSourceNames[static_cast<int>(source)])) return false;
    for (int i = 0; i < static_cast<int>(std::size(kSourceNames)); ++i) {
        const auto candidate = static_cast<Source>(i);
        if (renderer.has(candidate) && ImGui::Selectable(kSourceNames[i], candidate == source)) {
            source = candidate, changed = true;
        }
    }
    ImGui::EndCombo();
    return changed;
}

/// The lights of the scene, and how their bake goes.
void lightPanel(LightBench& bench) {
    if (bench.lights().empty() || !ImGui::CollapsingHeader("Lights", ImGuiTreeNodeFlags_DefaultOpen)) return;
    if (bench.lights().size() > 1 && ImGui::BeginCombo("light", bench.lights()[bench.chosen()].name.c_str())) {
        for (std::size_t n = 0; n < bench.lights().size(); ++n)
            if (ImGui::Selectable(bench.lights()[n].name.c_str(), n == bench.chosen())) bench.choose(n);
        ImGui::EndCombo();
    }
    const Light& light = bench.lights()[bench.chosen()];
    glm::vec3 position(light.position.value_or(glm::dvec3(0)));
    glm::vec2 angles(anglesOf(light.direction));
    bool moved = false;
    if (light.position)
        moved = ImGui::DragFloat3("position", glm::value_ptr(position), 0.005f, 0, 0, "%.3f m") || moved;
    if (light.type != LightType::Point) {
        moved = ImGui::SliderFloat("azimuth", &angles.x, -180, 180, "%.1f deg") || moved;
        moved = ImGui::SliderFloat("height", &angles.y, -89, 89, "%.1f deg") || moved;
    }
    if (moved) bench.moveTo(position, directionOf(angles));
    if (ImGui::Button("bake")) bench.bake();
    const std::string words = bench.words();
    if (bench.busy() && bench.rebake().phase() != Rebake::Phase::Failed) {
        ImGui::SameLine();
        ImGui::ProgressBar(static_cast<float>(bench.done()));
    }
    if (!words.empty()) ImGui::TextWrapped("%s", words.c_str());
}

/// The panel. @return the frame that is wanted
int panel(Picture& p, const Show& show, const Options& options, const Renderer& renderer, LightBench* bench,
          bool& playing) {
    int frame = show.frame();
    ImGui::SetNextWindowPos({10, 10}, ImGuiCond_Once);
    ImGui::SetNextWindowSize({330, 0}, ImGuiCond_Once);
    ImGui::Begin("Light");
    ImGui::Text("%.2f ms, %s", 1000.0 / static_cast<double>(ImGui::GetIO().Framerate), renderer.device().c_str());
    chooseSource("left (A)", p.left, renderer);
    chooseSource("right (B)", p.right, renderer);
    ImGui::SliderFloat("split", &p.split, 0, 1);
    ImGui::SliderFloat("exposure", &p.exposure, 0.05f, 20, "%.2f", ImGuiSliderFlags_Logarithmic);
    ImGui::SliderFloat("skylight", &p.ambient, 0, 1);
    ImGui::SliderFloat("tiles [m]", &p.tile_size, 0, 1);
    ImGui::Checkbox("water's surface", &p.surface);
    if (renderer.hasObjects()) {
        ImGui::Checkbox("objects", &p.objects);
        ImGui::SliderAngle("environment", &p.turn);
    }
    if (options.last_frame > options.first_frame) {
        ImGui::SliderInt("frame", &frame, options.first_frame, options.last_frame);
        ImGui::SameLine();
        ImGui::Checkbox("play", &playing);
    }
    if (bench) lightPanel(*bench);
    if (ImGui::CollapsingHeader("Water", ImGuiTreeNodeFlags_DefaultOpen)) {
        ImGui::SliderFloat3("scattering", glm::value_ptr(p.scattering), 0, 0.5f, "%.3f /m");
        ImGui::SliderFloat3("extinction", glm::value_ptr(p.extinction), 0, 2, "%.3f /m");
        ImGui::SliderFloat("g", &p.anisotropy, -0.95f, 0.95f);
        ImGui::SliderInt("steps", &p.steps, 4, 128);
    }
    if (ImGui::CollapsingHeader("Ball", ImGuiTreeNodeFlags_DefaultOpen)) {
        const float extent = glm::length(show.stage().max - show.stage().min);
        ImGui::DragFloat3("centre", glm::value_ptr(p.ball_centre), 0.002f * extent, 0, 0, "%.3f m");
        ImGui::SliderFloat("radius", &p.ball_radius, 0, 0.25f * extent, "%.3f m");
    }
    if (ImGui::CollapsingHeader("Without a bake")) {
        ImGui::SliderFloat("tau of the look-up", &p.tightening, 1, 3000, "%.0f", ImGuiSliderFlags_Logarithmic);
        ImGui::SliderInt("samples a volume", &p.warped_step, 1, 16);
    }
    ImGui::End();
    return frame;
}

}  // namespace

void openWindow(const Options& options) {
    const Window window(options.width, options.height);
    auto renderer = Renderer::create(
        {[](void*, const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); }, nullptr});
    if (!renderer) throwFailure("GL", renderer.error().message);
    Show show(options, **renderer);
    std::optional<LightBench> bench;
    if (!options.scene.empty()) bench.emplace(options, show, **renderer, photicBesideThis());
    bool playing = false;
    for (int drawn = 0; !glfwWindowShouldClose(window.handle()) && !stopWanted(); ++drawn) {
        if (options.frames_to_draw > 0 && drawn >= options.frames_to_draw) break;
        glfwPollEvents();
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
        LightBench* const lights = bench ? &*bench : nullptr;
        followMouse(show.picture, show.stage(), lights);
        if (ImGui::IsKeyPressed(ImGuiKey_Space, false)) playing = !playing;
        int wanted = panel(show.picture, show, options, **renderer, lights, playing);
        if (playing) wanted = wanted >= options.last_frame ? options.first_frame : wanted + 1;
        show.setFrame(wanted);
        if (lights) lights->update();
        ImGui::Render();

        int width = 0, height = 0;
        glfwGetFramebufferSize(window.handle(), &width, &height);
        if (width > 0 && height > 0) {
            if (const auto status = (*renderer)->draw(show.picture, 0, width, height); !status) {
                throwFailure("draw", status.error().message);
            }
        }
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        glfwSwapBuffers(window.handle());
    }
}

}  // namespace photic::viewer
