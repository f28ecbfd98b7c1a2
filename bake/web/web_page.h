// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bake/file/texture_3d.h"
#include "bake/scene/scene.h"

namespace photic {

/// A frame of a page: its number, and the name of the file that holds it, beside the page.
struct WebFrame {
    int frame = 0;
    std::string file;
};

/// What a page is made of besides its light.
struct WebScene {
    const Scene& scene;
    double frames_per_second = 24;
    std::vector<WebFrame> frames;
};

// The files of a page are text. All that it loads are classic scripts, since a page that was opened by double click may
// load nothing else; docs/web.md describes them.

/// `frame.NNNN.js`: the light of one frame, and the heights of its water.
/// @param scene  of that frame
std::string webFrameScript(int frame, const DenseTexels& light, const Scene& scene);

/// `scene.js`: receivers, water, glass, the medium, the camera, and the list of frames, which share the texels' box.
std::string webSceneScript(const WebScene& page, const LightVolume& volume, const DenseTexels& light);

/// `index.html` and `photic.js`: the same for every scene.
/// @param script  where the page finds photic.js
std::string webPageHtml(std::string_view script = "photic.js");
std::string webPageScript();

}  // namespace photic
