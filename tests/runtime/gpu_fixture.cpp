// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/gpu_fixture.h"

#include "tests/runtime/loaded_volume.h"

namespace photic::test {

using namespace runtime;

Volume makeVolume(const NvdbSpec& spec) { return loaded(spec); }

GpuVolume WithGpu::upload(const Volume& volume, const UploadOptions& options) {
    auto uploaded = GpuVolume::upload(*gpu_, volume, options);
    if (!uploaded) {
        ADD_FAILURE() << uploaded.error().message;
        uploaded = GpuVolume::upload(*gpu_, Volume());
    }
    return std::move(*uploaded);
}

std::vector<GpuSample> WithGpu::sample(GpuVolume& volume, const std::vector<std::array<float, 4>>& positions,
                                       const GlslOptions& options) {
    auto sampler = ComputeSampler::make(gl_, positions, volume, options);
    if (!sampler) {
        ADD_FAILURE() << sampler.error().message;
        return std::vector<GpuSample>(positions.size());
    }
    (*sampler)->run(volume);
    return (*sampler)->samples();
}

}  // namespace photic::test
