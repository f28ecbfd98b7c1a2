// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/scene/gltf_container.h"

namespace tinygltf {
class Model;
}

namespace photic {

/// A glTF whose parts are read but not yet believed: every index that it holds is checked where it is followed.
class GltfModel {
public:
    /// @param path  for messages
    /// @throws Error{Input} for what is no glTF
    GltfModel(GltfContainer container, std::string path);
    ~GltfModel();
    GltfModel(GltfModel&&) noexcept;
    GltfModel& operator=(GltfModel&&) noexcept;

    const tinygltf::Model& parts() const { return *model_; }
    const std::string& path() const { return path_; }
    /// What of the file is left out, the container's.
    const GltfContainer& container() const { return container_; }

    /// All numbers of an accessor, element by element, with what a sparse one replaces; integers that stand for
    /// fractions of their largest become these.
    /// @param components  numbers an element, which the accessor must have
    /// @param what        it is, for messages
    /// @throws Error{Input} where it does not lie within its buffer
    std::vector<double> numbers(int accessor, std::size_t components, const char* what) const;

    /// An index into a list of `count`.
    /// @throws Error{Input} where it is none
    std::size_t checked(int index, std::size_t count, const char* what) const;
    /// @throws Error{Input} with the file's name
    [[noreturn]] void fail(const std::string& what) const;

private:
    struct Run;
    std::vector<double> readRun(const Run& run, int accessor, std::size_t stride) const;

    std::unique_ptr<tinygltf::Model> model_;
    GltfContainer container_;  // without its buffers, which the model has
    std::string path_;
};

/// The triangles of a glTF that is open, as readGltf() of mesh_file.h gives them.
RawMesh readGltf(const GltfModel& model);

}  // namespace photic
