// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/gltf_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>
#include <utility>

#define TINYGLTF_IMPLEMENTATION
#include "bake/libraries/tiny_gltf.h"
#include "bake/report/error.h"

namespace photic {
namespace {

constexpr std::size_t kMostElements = std::size_t{1} << 28;  // of an accessor

bool ignoreImage(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
    return true;
}

/// The buffer of the container that a name stands for, or null.
const std::string* bufferNamed(const std::string& name, void* container) {
    constexpr std::string_view kPrefix = "photic-buffer-";
    const auto& buffers = static_cast<const GltfContainer*>(container)->buffers;
    const std::size_t at = name.rfind(kPrefix);
    std::size_t i = buffers.size();
    if (at != name.npos) std::from_chars(name.data() + at + kPrefix.size(), name.data() + name.size(), i);
    return i < buffers.size() ? &buffers[i] : nullptr;
}

bool bufferExists(const std::string& name, void* container) { return bufferNamed(name, container) != nullptr; }
std::string sameName(const std::string& name, void*) { return name; }
bool takeBuffer(std::vector<unsigned char>* out, std::string*, const std::string& name, void* container) {
    const std::string* bytes = bufferNamed(name, container);
    if (bytes) out->assign(bytes->begin(), bytes->end());
    return bytes != nullptr;
}
bool sizeOfBuffer(std::size_t* size, std::string*, const std::string& name, void* container) {
    const std::string* bytes = bufferNamed(name, container);
    if (bytes) *size = bytes->size();
    return bytes != nullptr;
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename T>
void copyRun(const unsigned char* at, std::size_t step, std::size_t count, std::size_t components, bool normalised,
             double* out) {
    const double unit = normalised && std::numeric_limits<T>::is_integer
                            ? 1.0 / static_cast<double>(std::numeric_limits<T>::max())
                            : 1.0;
    for (std::size_t i = 0; i < count; ++i, at += step)
        for (std::size_t c = 0; c < components; ++c) {
            T value;
            std::memcpy(&value, at + c * sizeof(T), sizeof(T));
            *out++ = std::max(static_cast<double>(value) * unit, unit == 1 ? -kInfinity : -1.0);
        }
}

tinygltf::Model parsed(GltfContainer& container, const std::string& path) {
    if (container.json.size() > std::numeric_limits<unsigned>::max())
        throw Error(ErrorCode::Input,
                    fmt::format("'{}' has {} bytes of JSON; it may have up to 4 GiB", path, container.json.size()));
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(ignoreImage, nullptr);
    gltf::useFiles(loader, {bufferExists, sameName, takeBuffer, sizeOfBuffer, &container});
    tinygltf::Model model;
    std::string error, warning;
    bool ok = false;
    try {
        ok = loader.LoadASCIIFromString(&model, &error, &warning, container.json.data(),
                                        static_cast<unsigned>(container.json.size()), "");
    } catch (const std::exception& failure) {
        error = failure.what();
    }
    if (!ok) {
        while (!error.empty() && error.back() == '\n') error.pop_back();
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}', which is damaged or no glTF 2.0: {}", path,
                                                  error.empty() ? "unknown reason" : error));
    }
    container.buffers.clear();  // the model has its own
    return model;
}

}  // namespace

GltfModel::GltfModel(GltfContainer container, std::string path)
    : model_(std::make_unique<tinygltf::Model>(parsed(container, path))),
      container_(std::move(container)),
      path_(std::move(path)) {}
GltfModel::~GltfModel() = default;
GltfModel::GltfModel(GltfModel&&) noexcept = default;
GltfModel& GltfModel::operator=(GltfModel&&) noexcept = default;

void GltfModel::fail(const std::string& what) const {
    throw Error(ErrorCode::Input, fmt::format("'{}' {}", path_, what));
}

std::size_t GltfModel::checked(int index, std::size_t count, const char* what) const {
    if (index < 0 || static_cast<std::size_t>(index) >= count)
        fail(fmt::format("refers to {} {}, but has {}", what, index, count));
    return static_cast<std::size_t>(index);
}

/// Elements that follow one another in a buffer view.
struct GltfModel::Run {
    int buffer_view = -1;
    std::size_t byte_offset = 0;
    std::size_t count = 0, components = 0;
    int component_type = 0;
    bool normalised = false;  ///< integers stand for fractions of their largest
};

/// The numbers of a run, where all of it lies within its buffer.
std::vector<double> GltfModel::readRun(const Run& run, int accessor, std::size_t stride) const {
    const tinygltf::BufferView& view =
        model_->bufferViews[checked(run.buffer_view, model_->bufferViews.size(), "buffer view")];
    const std::vector<unsigned char>& data =
        model_->buffers[checked(view.buffer, model_->buffers.size(), "buffer")].data;
    const int component = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(run.component_type));
    const std::size_t size = run.components * static_cast<std::size_t>(std::max(component, 0));
    const std::size_t step = stride > 0 ? stride : size;
    const std::size_t room =
        data.size() < view.byteOffset ? 0 : std::min(data.size() - view.byteOffset, view.byteLength);
    const bool fits = size > 0 && step >= size && run.byte_offset <= room && room - run.byte_offset >= size &&
                      run.count > 0 && run.count - 1 <= (room - run.byte_offset - size) / step;
    if (!fits)
        fail(fmt::format("accessor {} ({} elements) reaches beyond its buffer; the file is damaged or truncated",
                         accessor, run.count));
    std::vector<double> out(run.count * run.components);
    const unsigned char* at = data.data() + view.byteOffset + run.byte_offset;
    const auto copy = [&](const auto& copy_run) {
        copy_run(at, step, run.count, run.components, run.normalised, out.data());
    };
    switch (run.component_type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            copy(copyRun<std::int8_t>);
            break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            copy(copyRun<std::uint8_t>);
            break;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            copy(copyRun<std::int16_t>);
            break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            copy(copyRun<std::uint16_t>);
            break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            copy(copyRun<std::uint32_t>);
            break;
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            copy(copyRun<float>);
            break;
        default:
            fail(fmt::format("accessor {} holds numbers of type {}, which glTF does not know", accessor,
                             run.component_type));
    }
    return out;
}

std::vector<double> GltfModel::numbers(int index, std::size_t components, const char* what) const {
    const tinygltf::Accessor& accessor = model_->accessors[checked(index, model_->accessors.size(), "accessor")];
    if (tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)) != static_cast<int>(components))
        fail(fmt::format("accessor {} ({}) does not hold {} numbers an element", index, what, components));
    if (accessor.count > kMostElements)
        fail(fmt::format("accessor {} has {} elements; up to {} are read", index, accessor.count, kMostElements));
    Run run{accessor.bufferView, accessor.byteOffset,    accessor.count,
            components,          accessor.componentType, accessor.normalized};
    std::vector<double> out;
    if (accessor.bufferView >= 0) {
        const tinygltf::BufferView& view =
            model_->bufferViews[checked(accessor.bufferView, model_->bufferViews.size(), "buffer view")];
        out = readRun(run, index, view.byteStride);
    } else {
        out.assign(accessor.count * components, 0.0);  // the standard's meaning
    }
    if (!accessor.sparse.isSparse) return out;
    const auto& sparse = accessor.sparse;
    const auto count = static_cast<std::size_t>(std::max(sparse.count, 0));
    const std::vector<double> places =
        readRun({sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset), count, 1,
                 sparse.indices.componentType, false},
                index, 0);
    run.buffer_view = sparse.values.bufferView, run.count = count;
    run.byte_offset = static_cast<std::size_t>(sparse.values.byteOffset);
    const std::vector<double> values = readRun(run, index, 0);
    for (std::size_t i = 0; i < count; ++i) {
        if (!(places[i] >= 0 && places[i] < static_cast<double>(accessor.count)))
            fail(fmt::format("accessor {} replaces element {} of {}", index, places[i], accessor.count));
        std::copy_n(&values[i * components], components, &out[static_cast<std::size_t>(places[i]) * components]);
    }
    return out;
}

}  // namespace photic
