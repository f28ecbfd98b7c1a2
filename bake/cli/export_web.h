// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bake/cli/verbs.h"
#include "bake/file/output_set.h"
#include "bake/file/voxel_box.h"
#include "bake/web/web_page.h"

namespace photic::cli {

/// `export --web FOLDER`: a page that shows volumes with their scene in a browser. Frames come one after the other, as
/// they do of every export; then the page around them.
class WebExport {
public:
    /// The name of a page's frames, #### for their number.
    static std::string frameFiles(const std::string& folder);

    /// Claims the page's own files, before any is made.
    WebExport(const ExportArguments& arguments, OutputSet& outputs);

    /// What the page will list: all frames, in the order in which they are written.
    void expect(std::vector<WebFrame> frames) { frames_ = std::move(frames); }
    /// A volume, the file that it is from, and the box of it that is shown.
    struct Shown {
        const std::string& path;
        const LightVolume& volume;
        const std::optional<VoxelBox>& box;
    };
    /// Writes the file of one frame, and warns of what browsers may not take and of a scene that is another's.
    DenseWritten writeFrame(OutputSet& outputs, const std::string& output, const Shown& shown, Terminal& terminal);
    /// Writes the page. Its first file is what a person opens, and appears last.
    void finish(OutputSet& outputs, Terminal& terminal);

private:
    std::string pathOf(const char* name) const;
    std::string scriptPath() const;
    void warnOfSize(const DenseTexels& texels, Terminal& terminal) const;

    std::string folder_, scene_file_;
    bool shared_script_;
    std::vector<WebFrame> frames_;
    std::string scene_script_;
    std::size_t bytes_ = 0;
};

}  // namespace photic::cli
