// SPDX-License-Identifier: Apache-2.0
#include <epoxy/gl.h>

#include "bake/file/output_set.h"
#include "bake/image/atomic_file.h"
#include "bake/image/image.h"
#include "runtime/headless/headless_gl.h"
#include "runtime/viewer/light_bench.h"
#include "runtime/viewer/show.h"

namespace photic::viewer {

void takeScreenshot(const Options& options) {
    OutputSet outputs;
    outputs.writes("the screenshot", options.screenshot);
    std::string reason;
    const auto gl = runtime::HeadlessGl::make(reason);
    if (!gl) throwFailure("GL", reason);
    auto renderer = Renderer::create(gl->loader());
    if (!renderer) throwFailure("GL", renderer.error().message);
    const FilesRead files;
    Show show(options, **renderer);
    if (options.bake) LightBench(options, show, **renderer, photicBesideThis()).finish(stopWanted);
    outputs.reads("a volume that is shown", options.volumes);
    outputs.reads("an object that is shown", options.objects);
    outputs.reads("a file of the scene", files.paths());

    const int width = options.width * options.supersample, height = options.height * options.supersample;
    GLuint texture = 0, framebuffer = 0;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, width, height);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    if (const auto drawn = (*renderer)->draw(show.picture, framebuffer, width, height); !drawn) {
        throwFailure("draw", drawn.error().message);
    }
    std::vector<unsigned char> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &texture);

    Image image{options.width, options.height, 3, {}};
    image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
    const int n = options.supersample;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            for (int c = 0; c < 3; ++c) {
                int sum = 0;
                for (int k = 0; k < n * n; ++k) {
                    const int px = x * n + k % n, py = height - 1 - (y * n + k / n);
                    sum += pixels[(static_cast<std::size_t>(py) * static_cast<std::size_t>(width) +
                                   static_cast<std::size_t>(px)) *
                                      4 +
                                  static_cast<std::size_t>(c)];
                }
                image.at(x, y, c) = static_cast<float>(sum) / static_cast<float>(255 * n * n);
            }
        }
    }
    outputs.write(options.screenshot, encodePng(options.screenshot, image));
    outputs.commit();
}

}  // namespace photic::viewer
