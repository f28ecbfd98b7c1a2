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

void followMouse(Picture& picture, const Stage& stage) {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantCaptureMouse) return;
    Camera& camera = picture.camera;
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

/// The panel. @return the frame that is wanted
int panel(Picture& p, const Show& show, const Options& options, const Renderer& renderer, bool& playing) {
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
    bool playing = false;
    for (int drawn = 0; !glfwWindowShouldClose(window.handle()); ++drawn) {
        if (options.frames_to_draw > 0 && drawn >= options.frames_to_draw) break;
        glfwPollEvents();
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
        followMouse(show.picture, show.stage());
        if (ImGui::IsKeyPressed(ImGuiKey_Space, false)) playing = !playing;
        int wanted = panel(show.picture, show, options, **renderer, playing);
        if (playing) wanted = wanted >= options.last_frame ? options.first_frame : wanted + 1;
        show.setFrame(wanted);
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
