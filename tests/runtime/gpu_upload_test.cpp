// SPDX-License-Identifier: Apache-2.0
// A volume that goes to the GPU in parts is the one that goes at once, and no part is larger than was asked for.
#include <algorithm>
#include <chrono>
#include <thread>

#include "photic/gpu_upload.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/gpu_fixture.h"
#include "tests/runtime/wrapped_gl.h"

namespace photic::runtime {
namespace {

test::NvdbSpec blobs(bool coloured) {
    test::NvdbSpec spec;
    spec.min = {-7, -3, 2}, spec.max = {60, 62, 61};
    spec.values = test::swirl;
    spec.active = [](int i, int j, int k) {
        return (i - 20) * (i - 20) + (j - 30) * (j - 30) + (k - 30) * (k - 30) < 400;
    };
    spec.coloured = coloured;
    spec.json = R"({"reference_irradiance": 2.0})";
    return spec;
}

/// A GL that notes how many texels and bytes each call sends.
class CountingGl : public test::WrappedGl {
public:
    explicit CountingGl(GlLoader driver) : WrappedGl(driver) {
        largest = sent = 0;
        real("glTexSubImage3D", real_image);
        real("glBufferSubData", real_data);
        replace("glTexSubImage3D", &image);
        replace("glBufferSubData", &data);
    }
    static inline std::uint64_t largest = 0, sent = 0;  ///< [bytes]

private:
    static inline PFNGLTEXSUBIMAGE3DPROC real_image = nullptr;
    static inline PFNGLBUFFERSUBDATAPROC real_data = nullptr;
    static void count(std::uint64_t bytes) { largest = std::max(largest, bytes), sent += bytes; }
    static void image(GLenum target, GLint level, GLint x, GLint y, GLint z, GLsizei w, GLsizei h, GLsizei d,
                      GLenum format, GLenum type, const void* texels) {
        count(static_cast<std::uint64_t>(w) * static_cast<std::uint64_t>(h) * static_cast<std::uint64_t>(d) *
              (format == GL_RGBA ? 8U : 4U));
        real_image(target, level, x, y, z, w, h, d, format, type, texels);
    }
    static void data(GLenum target, GLintptr at, GLsizeiptr size, const void* bytes) {
        count(static_cast<std::uint64_t>(size));
        real_data(target, at, size, bytes);
    }
};

class GpuUploads : public test::WithGpu {
protected:
    /// Steps until all is there.
    static Result<GpuVolume> inParts(const GpuContext& gpu, const Volume& volume, const UploadOptions& options,
                                     std::uint64_t bytes) {
        auto coming = GpuUpload::start(gpu, volume, options);
        if (!coming) return coming.error();
        while (!coming->step(bytes)) {
        }
        return coming->take();
    }
};

TEST_F(GpuUploads, AreTheVolumesThatGoAtOnce) {
    for (const bool coloured : {false, true}) {
        const Volume volume = test::makeVolume(blobs(coloured));
        const auto positions = test::randomPositions(volume, 50000, 3);
        for (const Layout layout : {Layout::Atlas, Layout::Dense, Layout::Buffer}) {
            UploadOptions options;
            options.layout = layout;
            CountingGl counted(context_->loader());
            const auto gpu = GpuContext::create(counted.loader());
            ASSERT_TRUE(gpu.ok());
            GpuVolume whole = upload(volume, options);
            constexpr std::uint64_t kPart = 100000;
            auto parts = inParts(*gpu, volume, options, kPart);
            ASSERT_TRUE(parts.ok()) << parts.error().message;
            EXPECT_EQ(parts->info().layout, layout);
            EXPECT_EQ(parts->info().bytes, whole.info().bytes);
            EXPECT_EQ(sample(*parts, positions), sample(whole, positions));
            EXPECT_LE(CountingGl::largest, kPart);
            EXPECT_GE(CountingGl::sent + sizeof(VolumeBytes::parameters), whole.info().bytes);
            EXPECT_GT(CountingGl::sent, 5 * kPart);
        }
    }
}

TEST_F(GpuUploads, BringBothLobes) {
    const Volume volume = test::opposedSuns();
    const auto positions = test::randomPositions(volume, 50000, 4);
    GpuVolume whole = upload(volume, {});
    auto parts = inParts(*gpu_, volume, {}, 1 << 16);
    ASSERT_TRUE(parts.ok()) << parts.error().message;
    EXPECT_EQ(sample(*parts, positions), sample(whole, positions));
    ASSERT_NE(parts->secondLobe(), nullptr);
    EXPECT_EQ(sample(*parts->secondLobe(), positions), sample(*whole.secondLobe(), positions));
}

TEST_F(GpuUploads, FallBackAsUploadsDo) {
    const Volume volume = test::makeVolume(blobs(false));
    test::StarvedGl poor(context_->loader(), 20000);
    const auto starved = GpuContext::create(poor.loader());
    ASSERT_TRUE(starved.ok());
    auto parts = inParts(*starved, volume, {}, 1 << 20);
    ASSERT_TRUE(parts.ok()) << parts.error().message;
    EXPECT_EQ(parts->info().layout, Layout::Buffer);
    test::StarvedGl::largest = 0;
    EXPECT_EQ(inParts(*starved, volume, {}, 1 << 20).error().code, ErrorCode::Memory);
    UploadOptions none;
    none.budget = 100, none.when_too_large = WhenTooLarge::Refuse;
    EXPECT_EQ(inParts(*gpu_, volume, none, 1 << 20).error().code, ErrorCode::Limit);
}

TEST_F(GpuUploads, MayBeGivenUpAndForgotten) {
    const Volume volume = test::makeVolume(blobs(false));
    {
        auto given_up = GpuUpload::start(*gpu_, volume);
        ASSERT_TRUE(given_up.ok());
    }
    auto coming = GpuUpload::start(*gpu_, volume);
    ASSERT_TRUE(coming.ok());
    GLint bound = -1;
    for (int n = 0; n < 100 && !coming->step(1000); ++n) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    gl_.GetIntegerv(GL_TEXTURE_BINDING_3D, &bound);
    EXPECT_EQ(bound, 0) << "GL's state is as it was";
    coming->abandon();
    EXPECT_TRUE(coming->step());
    EXPECT_EQ(coming->take().error().code, ErrorCode::Usage);
    // All at once, without a step before.
    auto at_once = GpuUpload::start(*gpu_, volume);
    ASSERT_TRUE(at_once.ok());
    EXPECT_TRUE(at_once->take().ok());
}

}  // namespace
}  // namespace photic::runtime
