// SPDX-License-Identifier: Apache-2.0
// The smallest game: a window, a light volume, and a ball that swims through its light. Forward shading: the game's own
// shader calls photicIrradiance(). `game pool.nvdb`; a number of frames behind it ends the game after so many.
#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <photic/runtime.h>
#include <photic/runtime_gl.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

using namespace photic::runtime;

static const char* const kVertex = R"(#version 430 core
uniform vec3 centre, eye;   // [m]
uniform float radius, aspect;
out vec3 world, normal;
void main() {
    // A ball of 32 x 32 cells, from the vertex's number alone.
    int cell = gl_VertexID / 6, corner = gl_VertexID % 6;
    vec2 at = vec2(cell % 32 + (corner == 1 || corner == 2 || corner == 4 ? 1 : 0), cell / 32 + (corner == 2 || corner > 3 ? 1 : 0));
    vec2 angle = at / 32.0 * vec2(6.2831853, 3.1415927);
    normal = vec3(sin(angle.y) * cos(angle.x), sin(angle.y) * sin(angle.x), cos(angle.y));
    world = centre + radius * normal;
    // A camera that looks along +y, 60 degrees high.
    vec3 seen = world - eye;
    gl_Position = vec4(seen.x * 1.732 / aspect, seen.z * 1.732, 0.5 * seen.y - 0.1, seen.y);
})";

// Behind photic's GLSL: what the light of the volume gives the ball's surface.
static const char* const kFragment = R"(
in vec3 world, normal;
uniform float exposure;
out vec4 colour;
void main() {
    vec3 irradiance = photicIrradiance(world, normalize(normal));
    vec3 radiance = irradiance * 0.8 / 3.14159265 * exposure;
    colour = vec4(pow(radiance / (1.0 + radiance), vec3(1.0 / 2.2)), 1.0);
})";

static int fail(const std::string& why) {
    std::fprintf(stderr, "game: %s\n", why.c_str());
    return 1;
}

static GLuint makeProgram(const std::string& fragment) {
    const GLuint program = glCreateProgram();
    const char* texts[] = {kVertex, fragment.c_str()};
    for (int i = 0; i < 2; ++i) {
        const GLuint shader = glCreateShader(i == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
        glShaderSource(shader, 1, &texts[i], nullptr);
        glCompileShader(shader);
        glAttachShader(program, shader);
    }
    glLinkProgram(program);
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    return linked ? program : 0;
}

static int play(GLFWwindow* window, const Volume& volume, int frames) {
    const auto gpu =
        GpuContext::create({[](void*, const char* name) { return (void*)glfwGetProcAddress(name); }, nullptr});
    if (!gpu) return fail(gpu.error().message);
    auto light = GpuVolume::upload(*gpu, volume);
    if (!light) return fail(light.error().message);
    const GLuint program = makeProgram("#version 430 core\n" + volumeGlsl() + kFragment);
    if (!program) return fail("its shader does not link");
    GLuint vertices = 0;
    glGenVertexArrays(1, &vertices);

    // The ball circles in the middle of the light's box.
    const VoxelBox box = volume.litVoxels();
    const Vec3 low = volume.voxelCentre(box.min[0], box.min[1], box.min[2]);
    const Vec3 high = volume.voxelCentre(box.max[0], box.max[1], box.max[2]);
    const double size = high.x - low.x, x = (low.x + high.x) / 2, y = (low.y + high.y) / 2, z = (low.z + high.z) / 2;
    const auto uniform = [&](const char* name) { return glGetUniformLocation(program, name); };
    int lit = 0;
    for (int frame = 0; !glfwWindowShouldClose(window) && (frames == 0 || frame < frames); ++frame) {
        glfwPollEvents();
        int width = 1, height = 1;
        glfwGetFramebufferSize(window, &width, &height);
        glViewport(0, 0, width, height);
        glEnable(GL_DEPTH_TEST);
        glClearColor(0.02f, 0.05f, 0.07f, 1);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        glUseProgram(program);
        light->bind();
        glUniform3f(uniform("centre"), float(x + 0.2 * size * std::cos(0.02 * frame)),
                    float(y + 0.2 * size * std::sin(0.02 * frame)), float(z));
        glUniform3f(uniform("eye"), float(x), float(y - size), float(z + 0.15 * size));
        glUniform1f(uniform("radius"), float(0.2 * size));
        glUniform1f(uniform("aspect"), float(width) / float(height));
        glUniform1f(uniform("exposure"), float(4 / volume.metadata().reference_irradiance));
        glBindVertexArray(vertices);
        glDrawArrays(GL_TRIANGLES, 0, 32 * 32 * 6);
        if (frames > 0 && frame == frames - 1) {  // a test: is there light on the ball?
            for (int i = 0; i < 64; ++i) {
                unsigned char pixel[4] = {};
                glReadPixels(width / 4 + i * width / 128, height / 2, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
                lit += pixel[0] > 100;
            }
            std::printf("lit pixels: %d of 64\n", lit);
        }
        glfwSwapBuffers(window);
    }
    return frames > 0 && lit == 0 ? fail("the ball is dark") : 0;
}

int main(int argc, char** argv) {
    if (argc < 2) return fail("which volume? game pool.nvdb");
    const auto volume = loadVolume(argv[1]);
    if (!volume) return fail(volume.error().message);
    if (!glfwInit()) return fail("there is no screen");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    GLFWwindow* window = glfwCreateWindow(960, 540, "A ball in the light", nullptr, nullptr);
    if (!window) return fail("there is no OpenGL 4.3 here");
    glfwMakeContextCurrent(window);
    const int code = play(window, *volume, argc > 2 ? std::atoi(argv[2]) : 0);
    glfwTerminate();
    return code;
}
