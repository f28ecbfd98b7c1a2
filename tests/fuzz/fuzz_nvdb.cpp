// SPDX-License-Identifier: Apache-2.0
// Whatever is in a file, the runtime refuses it or loads something harmless.
//
// A .nvdb is half a megabyte of which nearly all is zero, so blind mutations of whole files hardly ever meet a byte
// that steers the reader. An input is therefore a list of edits to a good file:
//   byte 0: 0 the rest is a whole file; 1 the rest is metadata; otherwise which good file, and edits follow:
//   1 byte how many bytes to write (0: cut the file here), 3 bytes where (in the list of bytes that are not zero, or
//   anywhere when the top bit is set), then the bytes.
#include <sanitizer/asan_interface.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include "photic/runtime.h"
#include "runtime/src/brick_plan.h"
#include "runtime/src/guarded.h"
#include "runtime/src/metadata_json.h"
#include "tests/runtime/nvdb_files.h"

namespace {

using namespace photic::runtime;
namespace test = photic::test;

struct GoodFile {
    std::vector<unsigned char> bytes;
    std::vector<std::size_t> live;  ///< places of bytes that are not zero
};

std::vector<GoodFile> makeGoodFiles() {
    std::vector<GoodFile> files;
    for (const test::NvdbEncoding encoding : {test::NvdbEncoding::Vec4, test::NvdbEncoding::Fp16,
                                              test::NvdbEncoding::Floats, test::NvdbEncoding::Direction}) {
        for (const bool coloured : {false, true}) {
            for (const test::NvdbPacking packing : {test::NvdbPacking::None, test::NvdbPacking::Blosc}) {
                test::NvdbSpec spec;
                // Two tiles in the root for one of them: the files are twice as large.
                const int first = encoding == test::NvdbEncoding::Floats ? -3 : 1;
                spec.min = {first, 0, 4};
                spec.max = {first + 12, 4, 9};
                spec.values = test::swirl;
                spec.encoding = encoding;
                spec.coloured = coloured;
                spec.packing = packing;
                spec.json = R"({"version": 1, "reference_irradiance": 1000, "ior": 1.33, "period": [13, 0, 0]})";
                GoodFile file{test::makeNvdb(spec), {}};
                for (std::size_t i = 0; i < file.bytes.size(); ++i) {
                    if (file.bytes[i] != 0) file.live.push_back(i);
                }
                files.push_back(std::move(file));
            }
        }
    }
    return files;
}

// Small, so that what can grow large is over soon.
constexpr std::uint64_t kLargestMemory = 1 << 18;

void demand(bool holds) {
    if (!holds) std::abort();
}

void read(const unsigned char* data, std::size_t size) {
    LoadOptions options;
    options.largest_memory = kLargestMemory;
    const Result<Volume> volume = readVolume(data, size, options);
    if (!volume) {
        demand(!volume.error().message.empty());
        return;
    }
    demand(volume->bytes() <= kLargestMemory + 4096);
    const VoxelBox box = volume->litVoxels();
    for (const double t : {-0.2, 0.0, 0.31, 0.5, 1.0, 1.3}) {
        const Vec3 a = volume->voxelCentre(box.min[0], box.min[1], box.min[2]);
        const Vec3 b = volume->voxelCentre(box.max[0], box.max[1], box.max[2]);
        const Vec3 p = {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)};
        const Light light = volume->sample(p);
        demand(std::isfinite(light.irradiance.x) && light.irradiance.x >= 0);
        demand(std::isfinite(light.flux.x) && std::isfinite(light.flux.y) && std::isfinite(light.flux.z));
        demand(std::isfinite(volume->irradiance(p, {0, 0, 1}).x));
    }
    // What an upload does before it comes to GL.
    (void)guarded([&]() -> Status {
        const BrickPlan plan = planBricks(volume->data(), 4 * kLargestMemory);
        std::vector<Half4> light(BrickPlan::kVoxels), rgb(BrickPlan::kVoxels);
        for (const BrickPlan::Brick& brick : plan.bricks) {
            fillBrick(volume->data(), brick.page, light.data(), volume->coloured() ? rgb.data() : nullptr);
        }
        (void)halfResolution(volume->data());
        return Done{};
    });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static std::vector<GoodFile> files = makeGoodFiles();
    if (size < 1) return 0;
    const std::uint8_t kind = data[0];
    ++data, --size;
    if (kind == 0) {
        read(data, size);
        return 0;
    }
    if (kind == 1) {
        (void)guarded([&]() -> Status {
            readMetadata({reinterpret_cast<const char*>(data), size});
            return Done{};
        });
        return 0;
    }
    GoodFile& good = files[kind % files.size()];
    // The edits are made in place and undone: copying megabytes would take most of the time.
    std::vector<std::pair<std::size_t, unsigned char>> undo;
    std::size_t length = good.bytes.size();
    while (size >= 4) {
        const std::size_t count = data[0] % 9;
        const std::size_t number = data[1] | data[2] << 8 | (data[3] & 0x7f) << 16;
        const std::size_t at = data[3] & 0x80 ? number % good.bytes.size() : good.live[number % good.live.size()];
        data += 4, size -= 4;
        if (count == 0) length = std::min(length, at);
        for (std::size_t i = 0; i < count && size > 0; ++i, ++data, --size) {
            if (at + i >= length) continue;
            undo.emplace_back(at + i, good.bytes[at + i]);
            good.bytes[at + i] = *data;
        }
    }
    // Nothing may be read beyond the cut.
    ASAN_POISON_MEMORY_REGION(good.bytes.data() + length, good.bytes.size() - length);
    read(good.bytes.data(), length);
    ASAN_UNPOISON_MEMORY_REGION(good.bytes.data() + length, good.bytes.size() - length);
    for (auto edit = undo.rbegin(); edit != undo.rend(); ++edit) good.bytes[edit->first] = edit->second;
    return 0;
}
