// SPDX-License-Identifier: Apache-2.0
// Every shader compiles with the reference compiler, for all versions that the library hands out: drivers are laxer.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "photic/bent_rays.h"
#include "photic/runtime_gl.h"
#include "runtime/src/shader_source.h"

namespace photic::runtime {
namespace {

std::string outputOf(const std::string& command, int& status) {
    std::string out;
    std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    if (!pipe) {
        status = -1;
        return out;
    }
    std::array<char, 4096> buffer;
    while (std::fgets(buffer.data(), buffer.size(), pipe)) out += buffer.data();
    status = pclose(pipe);
    return out;
}

/// The stage of "receiver.frag.glsl": "frag"; empty for files that are included.
std::string stageOf(const std::string& name) {
    for (const char* stage : {"vert", "frag", "comp"}) {
        if (name.find(std::string(".") + stage + ".glsl") != std::string::npos) return stage;
    }
    return {};
}

class Shaders : public testing::Test {
protected:
    void SetUp() override {
        int status = 0;
        outputOf("glslangValidator --version", status);
        if (status != 0) GTEST_SKIP() << "glslangValidator is not installed (glslang-tools)";
        file_ = std::filesystem::temp_directory_path() / ("photic_shader_" + std::to_string(::getpid()));
    }
    void TearDown() override { std::filesystem::remove(file_); }

    void expectCompiles(const std::string& text, const std::string& stage, const std::string& what,
                        const std::string& options = {}) {
        int status = 0;
        std::ofstream(file_) << text;
        const std::string log = outputOf("glslangValidator -S " + stage + " " + options + " " + file_.string(), status);
        EXPECT_EQ(status, 0) << what << ":\n" << log;
    }

    std::filesystem::path file_;
};

constexpr std::pair<GlslTarget, const char*> kTargets[] = {
    {GlslTarget::Gl430, "430"}, {GlslTarget::Gl460, "460"}, {GlslTarget::Es310, "310 es"}};

TEST_F(Shaders, PassesCompileInEveryVersion) {
    const std::vector<std::vector<Define>> variants = {{},
                                                       {{"PHOTIC_LAYOUT", "1"}},
                                                       {{"PHOTIC_LAYOUT", "2"}, {"PHOTIC_EXACT", "1"}},
                                                       {{"PHOTIC_LIGHT_IN_BUFFER", "1"}},
                                                       {{"PHOTIC_MOVERS", "1"}},
                                                       {{"PHOTIC_LIT", "1"}},
                                                       {{"PHOTIC_BENT_SHAPES", "1"}},
                                                       {{"PHOTIC_LIT", "1"}, {"PHOTIC_BENT_SHAPES", "1"}},
                                                       {{"PHOTIC_BENT_GRADIENTS", "1"}, {"PHOTIC_EULER", "1"}}};
    int compiled = 0;
    for (const std::string& name : embeddedShaders()) {
        const std::string stage = stageOf(name);
        if (stage.empty()) continue;
        for (const auto& [target, version] : kTargets) {
            for (const auto& defines : variants) {
                const auto text = assembleShader(name, target, defines);
                ASSERT_TRUE(text.ok()) << text.error().message;
                expectCompiles(text->text, stage, name + " as " + version);
                ++compiled;
                // Others do not look at the defines.
                if (text->text.find("photicLocal") == std::string::npos &&
                    text->text.find("photicBent") == std::string::npos && name != "god_rays.frag.glsl" &&
                    name != "warped_volume.frag.glsl")
                    break;
            }
        }
    }
    EXPECT_GT(compiled, 20);
}

TEST_F(Shaders, GamesShadersCompileWithTwoVolumes) {
    for (const auto& [target, version] : kTargets) {
        for (const Layout layout : {Layout::Automatic, Layout::Atlas, Layout::Dense, Layout::Buffer}) {
            for (const Filter filter : {Filter::Hardware, Filter::Exact}) {
                GlslOptions sun, lamp;
                sun.layout = lamp.layout = layout;
                sun.filter = lamp.filter = filter;
                lamp.prefix = "lamp";
                lamp.first_texture = 3;
                lamp.first_buffer = 1;
                sun.movers = lamp.movers = filter == Filter::Hardware;
                sun.mover_buffer = lamp.mover_buffer = 2;
                sun.mover_texture = lamp.mover_texture = 6;
                const auto header = assembleShader("full_screen.vert.glsl", target, {});
                std::string text =
                    header->text.substr(0, header->text.find("#line")) + volumeGlsl(sun) + volumeGlsl(lamp);
                text += R"(
                    in vec3 world;
                    in vec3 normal;
                    layout(location = 0) out vec4 color;
                    void main() {
                        PhoticMedium medium = PhoticMedium(vec3(0.1), vec3(0.2), 0.8);
                        PhoticRay ray = PhoticRay(world, normalize(normal));
                        vec3 light = photicIrradiance(world, normal) + lampIrradiance(world, normal);
                        light += photicInscatter(ray, 3.0, medium) + lampInscatter(ray, 3.0, medium, 16, 0.5, true);
                        light += photicSample(world).flux * lampEmpty(world, normal);
                        color = vec4(light, 1.0);
                    })";
                expectCompiles(text, "frag", std::string("two volumes as ") + version);
            }
        }
    }
}

// As SPIR-V for Vulkan, with two volumes in two descriptor sets.
TEST_F(Shaders, GamesShadersCompileForVulkan) {
    for (const Layout layout : {Layout::Automatic, Layout::Atlas, Layout::Dense, Layout::Buffer}) {
        for (const Filter filter : {Filter::Hardware, Filter::Exact}) {
            GlslOptions sun, lamp;
            sun.layout = lamp.layout = layout;
            sun.filter = lamp.filter = filter;
            sun.vulkan.emplace();
            lamp.prefix = "lamp";
            lamp.vulkan = VulkanBindings{1, 10, 11, 12, 13, 14, 15, 16};
            sun.movers = lamp.movers = filter == Filter::Hardware;
            const std::string text = "#version 450\n" + volumeGlsl(sun) + volumeGlsl(lamp) + R"(
                layout(location = 0) in vec3 world;
                layout(location = 1) in vec3 normal;
                layout(location = 0) out vec4 color;
                void main() {
                    PhoticMedium medium = PhoticMedium(vec3(0.1), vec3(0.2), 0.8);
                    PhoticRay ray = PhoticRay(world, normalize(normal));
                    vec3 light = photicIrradiance(world, normal) + lampIrradiance(world, normal);
                    light += photicInscatter(ray, 3.0, medium) + lampInscatter(ray, 3.0, medium, 16, 0.5, true);
                    color = vec4(light + photicSample(world).flux * lampEmpty(world, normal), 1.0);
                })";
            expectCompiles(text, "frag", "two volumes for Vulkan", "-V -o " + file_.string() + ".spv");
        }
    }
    // The bindings are those that were asked for.
    GlslOptions lamp;
    lamp.vulkan = VulkanBindings{1, 10, 11, 12, 13, 14};
    std::ofstream(file_) << "#version 450\n"
                         << volumeGlsl(lamp) << "layout(location = 0) out vec4 c;\n"
                         << "void main() { c = vec4(photicIrradiance(vec3(1.0), vec3(0.0, 0.0, 1.0)), 1.0); }\n";
    int status = 0;
    const std::string listing =
        outputOf("glslangValidator -S frag -V -H -o " + file_.string() + ".spv " + file_.string(), status);
    EXPECT_EQ(status, 0) << listing;
    for (const char* line :
         {"photic_light) Binding 10", "photic_light) DescriptorSet 1", "photic_pages) Binding 12", "Binding 13"})
        EXPECT_NE(listing.find(line), std::string::npos) << line;
    std::filesystem::remove(file_.string() + ".spv");
}

// Curved eye rays in a game's own shader: for OpenGL in every version, and for Vulkan in a set of their own.
TEST_F(Shaders, GamesShadersCompileWithBentRays) {
    constexpr const char* kMain = R"(
        layout(location = 0) in vec3 direction;
        layout(location = 0) out vec4 color;
        vec3 photicEnvironment(vec3 d) { return 0.5 * d + 0.5; }
        bool photicNearby(vec3 from, vec3 d, float limit, out vec3 radiance) {
            radiance = vec3(0.0);
            return false;
        }
        void main() {
            bool touched;
            color = vec4(photicBentRadiance(vec3(0.0), normalize(direction), vec3(1.0), 0, touched), 1.0);
            if (!touched) color *= photicBentAt(0, direction, 0).excess;
        })";
    for (const IndexLookup lookup : {IndexLookup::Spline, IndexLookup::Gradients}) {
        for (const bool scatters : {false, true}) {
            BentGlslOptions options;
            options.lookup = lookup, options.scatters = options.shapes = scatters;
            for (const auto& [target, version] : kTargets) {
                const auto header = assembleShader("full_screen.vert.glsl", target, {});
                expectCompiles(header->text.substr(0, header->text.find("#line")) + (scatters ? volumeGlsl() : "") +
                                   bentGlsl(options) + kMain,
                               "frag", std::string("bent rays as ") + version);
            }
            options.vulkan_set = 2;
            options.bindings = {7, 0, 1, 2, 3, 4, 5, 6};
            GlslOptions volume;
            volume.vulkan.emplace();
            expectCompiles("#version 450\n" + (scatters ? volumeGlsl(volume) : "") + bentGlsl(options) + kMain, "frag",
                           "bent rays for Vulkan", "-V -o " + file_.string() + ".spv");
        }
    }
    std::filesystem::remove(file_.string() + ".spv");
}

TEST_F(Shaders, TheCheckFails) {
    int status = 0;
    std::ofstream(file_) << "#version 430 core\nvoid main() { nonsense(); }\n";
    outputOf("glslangValidator -S frag " + file_.string(), status);
    EXPECT_NE(status, 0);
}

}  // namespace
}  // namespace photic::runtime
