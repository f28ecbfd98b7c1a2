// SPDX-License-Identifier: Apache-2.0
// Every public call of the GPU half in a GL that is poor, out of memory, too old, or gone: nothing waits, nothing is
// left, and what cannot be is said.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>

#include "tests/runtime/every_call.h"
#include "tests/runtime/wrapped_gl.h"

namespace photic::runtime {
namespace {

using test::Call;
using test::CallInputs;
using EveryCall = test::EveryCall;

/// A GL that counts what is made, deleted and waited for, and whose memory ends when it is told to.
class CountedGl : public test::WrappedGl {
public:
    explicit CountedGl(GlLoader driver) : WrappedGl(driver) {
        if (const auto made = loadGlFunctions(driver)) gl = *made;
        names.clear(), waits.clear();
        allocations = 0, failing = -1, pending = false, largest_side = 0, largest_buffer = 0;
        replace("glGenTextures", &make<&GlFunctions::GenTextures>),
            replace("glDeleteTextures", &drop<&GlFunctions::DeleteTextures>);
        replace("glGenBuffers", &make<&GlFunctions::GenBuffers>),
            replace("glDeleteBuffers", &drop<&GlFunctions::DeleteBuffers>);
        replace("glGenSamplers", &make<&GlFunctions::GenSamplers>),
            replace("glDeleteSamplers", &drop<&GlFunctions::DeleteSamplers>);
        replace("glGenFramebuffers", &make<&GlFunctions::GenFramebuffers>),
            replace("glDeleteFramebuffers", &drop<&GlFunctions::DeleteFramebuffers>);
        replace("glGenVertexArrays", &make<&GlFunctions::GenVertexArrays>),
            replace("glDeleteVertexArrays", &drop<&GlFunctions::DeleteVertexArrays>);
        replace("glCreateProgram", &program), replace("glDeleteProgram", &dropProgram);
        replace("glCreateShader", &shader), replace("glDeleteShader", &dropShader);
        replace("glTexStorage2D", &storage2d), replace("glTexStorage3D", &storage3d), replace("glBufferData", &data);
        replace("glGetError", &error);
        replace("glFinish", &finish), replace("glReadPixels", &readPixels), replace("glMapBufferRange", &map);
        replace("glClientWaitSync", &wait), replace("glGetTexImage", &texImage), replace("glGetQueryObjectuiv", &query);
        replace("glGetIntegerv", &integer), replace("glGetInteger64v", &integer64);
    }

    static inline GlFunctions gl;
    static inline std::map<int, int> names;           ///< made less deleted, by kind
    static inline std::set<std::string> waits;        ///< functions that wait for the GPU
    static inline int allocations = 0, failing = -1;  ///< of memory; which of them find none, from 0: -1, none
    static inline int most_3d = 0, most_2d = 0;       ///< what GL says of itself; 0: the truth
    static inline GLint64 most_storage = 0;
    static inline int largest_side = 0;           ///< of 3D textures that were made
    static inline GLsizeiptr largest_buffer = 0;  ///< of storage buffers

    static int left() {
        int sum = 0;
        for (const auto& [kind, count] : names) sum += std::abs(count);
        return sum;
    }

private:
    static inline bool pending = false;
    template <auto kMember>
    static void make(GLsizei count, GLuint* out) {
        names[kindOf(kMember)] += count;
        (gl.*kMember)(count, out);
    }
    template <auto kMember>
    static void drop(GLsizei count, const GLuint* in) {
        for (GLsizei n = 0; n < count; ++n) names[kindOf(kMember)] -= in[n] != 0;
        (gl.*kMember)(count, in);
    }
    /// Makers and deleters of one thing share a number.
    template <class Member>
    static int kindOf(Member member) {
        const auto is = [&](auto other) {
            if constexpr (std::is_same_v<Member, decltype(other)>) return member == other;
            return false;
        };
        if (is(&GlFunctions::GenTextures) || is(&GlFunctions::DeleteTextures)) return 0;
        if (is(&GlFunctions::GenBuffers) || is(&GlFunctions::DeleteBuffers)) return 1;
        if (is(&GlFunctions::GenSamplers) || is(&GlFunctions::DeleteSamplers)) return 2;
        if (is(&GlFunctions::GenFramebuffers) || is(&GlFunctions::DeleteFramebuffers)) return 3;
        return 4;
    }
    static GLuint program() { return ++names[5], gl.CreateProgram(); }
    static void dropProgram(GLuint name) { names[5] -= name != 0, gl.DeleteProgram(name); }
    static GLuint shader(GLenum stage) { return ++names[6], gl.CreateShader(stage); }
    static void dropShader(GLuint name) { names[6] -= name != 0, gl.DeleteShader(name); }

    /// Whether there is memory for another allocation.
    static bool room() {
        if (allocations++ != failing) return true;
        pending = true;
        return false;
    }
    static void storage2d(GLenum target, GLsizei levels, GLenum format, GLsizei w, GLsizei h) {
        if (room()) gl.TexStorage2D(target, levels, format, w, h);
    }
    static void storage3d(GLenum target, GLsizei levels, GLenum format, GLsizei w, GLsizei h, GLsizei d) {
        if (target == GL_TEXTURE_3D) largest_side = std::max({largest_side, w, h, d});
        if (room()) gl.TexStorage3D(target, levels, format, w, h, d);
    }
    static void data(GLenum target, GLsizeiptr size, const void* bytes, GLenum use) {
        if (target == GL_SHADER_STORAGE_BUFFER) largest_buffer = std::max(largest_buffer, size);
        if (room()) gl.BufferData(target, size, bytes, use);
    }
    static GLenum error() {
        if (!pending) return gl.GetError();
        pending = false;
        return GL_OUT_OF_MEMORY;
    }
    static void finish() { waits.insert("glFinish"), gl.Finish(); }
    static void readPixels(GLint x, GLint y, GLsizei w, GLsizei h, GLenum format, GLenum type, void* out) {
        waits.insert("glReadPixels"), gl.ReadPixels(x, y, w, h, format, type, out);
    }
    static void* map(GLenum target, GLintptr at, GLsizeiptr size, GLbitfield access) {
        waits.insert("glMapBufferRange");
        return gl.MapBufferRange(target, at, size, access);
    }
    static GLenum wait(GLsync sync, GLbitfield flags, GLuint64 time) {
        waits.insert("glClientWaitSync");
        return gl.ClientWaitSync(sync, flags, time);
    }
    static void texImage(GLenum target, GLint level, GLenum format, GLenum type, void* out) {
        waits.insert("glGetTexImage"), gl.GetTexImage(target, level, format, type, out);
    }
    static void query(GLuint id, GLenum what, GLuint* out) {
        waits.insert("glGetQueryObjectuiv"), gl.GetQueryObjectuiv(id, what, out);
    }
    static void integer(GLenum what, GLint* out) {
        gl.GetIntegerv(what, out);
        if (what == GL_MAX_3D_TEXTURE_SIZE && most_3d > 0) *out = most_3d;
        if (what == GL_MAX_TEXTURE_SIZE && most_2d > 0) *out = most_2d;
    }
    static void integer64(GLenum what, GLint64* out) {
        gl.GetInteger64v(what, out);
        if (what == GL_MAX_SHADER_STORAGE_BLOCK_SIZE && most_storage > 0) *out = most_storage;
    }
};

double relativeDifference(const std::vector<float>& a, const std::vector<float>& b) {
    double difference = 0, size = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        difference += std::fabs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
        size += std::fabs(static_cast<double>(b[i]));
    }
    return difference / size;
}

TEST_F(EveryCall, WaitsForNothingAndLeavesNothing) {
    CountedGl counted(context_->loader());
    const GpuContext gpu = contextOf(counted);
    for (const Call& call : inputs_->everyCall()) {
        CountedGl::names.clear();
        drawn(call, gpu);
        EXPECT_TRUE(CountedGl::waits.empty()) << call.name << " calls " << *CountedGl::waits.begin();
        EXPECT_EQ(CountedGl::left(), 0) << call.name;
    }
    // The count can fail: what reads back waits, and what is not deleted is left.
    GLuint texture = 0;
    gpu.gl().GenTextures(1, &texture);
    gpu.gl().Finish();
    EXPECT_EQ(CountedGl::left(), 1);
    EXPECT_EQ(CountedGl::waits.count("glFinish"), 1U);
    gpu.gl().DeleteTextures(1, &texture);
}

TEST_F(EveryCall, SaysWhenMemoryEndsWhereverItEnds) {
    CountedGl counted(context_->loader());
    const GpuContext gpu = contextOf(counted);
    const test::DrawnView view(gl_, inputs_->drawing);
    int refusals = 0;
    for (const Call& call : inputs_->everyCall()) {
        const std::vector<float> expected = drawn(call, gpu);
        const int all = (CountedGl::allocations = 0, drawn(call, gpu), CountedGl::allocations);
        EXPECT_GT(all, 0) << call.name;
        for (int n = 0; n < all; ++n) {
            CountedGl::allocations = 0, CountedGl::failing = n, CountedGl::names.clear();
            view.fill(0.25F, 0.5F, 0.75F);
            const Status done = call.run(gpu, view);
            CountedGl::failing = -1;
            if (!done) {
                EXPECT_EQ(done.error().code, ErrorCode::Memory) << call.name << ": " << done.error().message;
                ++refusals;
            } else {
                // Another layout may have been found instead; what is drawn is the same light.
                EXPECT_LT(relativeDifference(view.pixels(), expected), 0.01)
                    << call.name << " without memory for its allocation " << n;
            }
            EXPECT_EQ(CountedGl::left(), 0) << call.name << " without memory for its allocation " << n;
        }
        EXPECT_EQ(drawn(call, gpu), expected) << call.name << " after all that";
    }
    EXPECT_GT(refusals, 20);
}

TEST_F(EveryCall, FitsSmallTexturesAndStorage) {
    for (const auto& [side, storage] : {std::pair{32, GLint64{1} << 27}, {2048, GLint64{20000}}, {9, GLint64{20000}}}) {
        CountedGl counted(context_->loader());
        CountedGl::most_3d = side, CountedGl::most_storage = storage;
        const GpuContext gpu = contextOf(counted);
        CountedGl::most_3d = 0, CountedGl::most_storage = 0;
        EXPECT_EQ(gpu.gl().largest_texture_3d, side);
        const test::DrawnView view(gl_, inputs_->drawing);
        for (const Call& call : inputs_->everyCall()) {
            const Status done = call.run(gpu, view);
            if (!done) {
                EXPECT_EQ(done.error().code, ErrorCode::Limit) << call.name << ": " << done.error().message;
            }
            EXPECT_LE(CountedGl::largest_side, side) << call.name;
            EXPECT_LE(CountedGl::largest_buffer, storage) << call.name;
        }
        // What may choose always finds something.
        const auto any = GpuVolume::upload(gpu, inputs_->coloured);
        ASSERT_TRUE(any.ok()) << any.error().message;
        EXPECT_LE(CountedGl::largest_side, side);
        EXPECT_LE(CountedGl::largest_buffer, storage);
    }
}

TEST_F(EveryCall, NeedsComputeShadersOnlyForLiveBakes) {
    test::WrappedGl poor(context_->loader());
    for (const char* name : {"glDispatchCompute", "glBindImageTexture", "glMemoryBarrier"}) poor.hide(name);
    const GpuContext gpu = contextOf(poor);
    const test::DrawnView view(gl_, inputs_->drawing);
    for (const Call& call : inputs_->everyCall()) {
        if (call.name == "LiveBake::update") {
            const Status done = call.run(gpu, view);
            ASSERT_FALSE(done.ok());
            EXPECT_EQ(done.error().code, ErrorCode::Unsupported);
            EXPECT_NE(done.error().message.find("caustic map"), std::string::npos) << done.error().message;
        } else {
            EXPECT_EQ(drawn(call, gpu), drawn(call, *gpu_)) << call.name;
        }
    }
}

/// GL 3.3, and GL ES 3.0.
struct OldGl : test::WrappedGl {
    explicit OldGl(GlLoader driver, const char* version) : WrappedGl(driver) {
        real("glGetString", text), real("glGetIntegerv", integer);
        says = version;
        replace("glGetString", &string), replace("glGetIntegerv", &number);
    }
    static const GLubyte* string(GLenum what) {
        return what == GL_VERSION ? reinterpret_cast<const GLubyte*>(says) : text(what);
    }
    static void number(GLenum what, GLint* out) {
        integer(what, out);
        if (what == GL_MAJOR_VERSION) *out = 3;
        if (what == GL_MINOR_VERSION) *out = says[0] == 'O' ? 0 : 3;
    }
    inline static const char* says = nullptr;
    inline static PFNGLGETSTRINGPROC text = nullptr;
    inline static PFNGLGETINTEGERVPROC integer = nullptr;
};

TEST_F(EveryCall, SaysThatAnOldGlIsTooOld) {
    for (const char* version : {"3.3.0 NVIDIA 1.2", "OpenGL ES 3.0 Mesa"}) {
        OldGl old(context_->loader(), version);
        const auto made = GpuContext::create(old.loader());
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::Unsupported);
        EXPECT_NE(made.error().message.find(version), std::string::npos) << made.error().message;
        EXPECT_NE(made.error().message.find("4.3"), std::string::npos) << made.error().message;
    }
}

TEST_F(EveryCall, DrawsTheSameOnEs) {
    std::vector<std::vector<float>> desktop;
    for (const Call& call : inputs_->everyCall()) desktop.push_back(drawn(call, *gpu_));
    open(test::GlApi::Es31);
    if (IsSkipped()) return;
    makeContext();
    std::size_t n = 0;
    for (const Call& call : inputs_->everyCall()) {
        EXPECT_LT(relativeDifference(drawn(call, *gpu_), desktop[n]), 1e-3) << call.name;
        ++n;
    }
}

/// A GL that says that its context was lost.
struct LostGl : test::WrappedGl {
    explicit LostGl(GlLoader driver) : WrappedGl(driver) {
        lost = false;
        replace("glGetGraphicsResetStatus", &status);
    }
    static GLenum status() { return lost ? GL_UNKNOWN_CONTEXT_RESET : GL_NO_ERROR; }
    inline static bool lost = false;
};

TEST_F(EveryCall, SaysThatTheContextIsLost) {
    LostGl losing(context_->loader());
    const GpuContext gpu = contextOf(losing);
    const test::DrawnView view(gl_, inputs_->drawing);
    for (const Call& call : inputs_->everyCall()) {
        LostGl::lost = true;
        const Status done = call.run(gpu, view);
        LostGl::lost = false;
        ASSERT_FALSE(done.ok()) << call.name;
        EXPECT_EQ(done.error().code, ErrorCode::Lost) << call.name << ": " << done.error().message;
        EXPECT_NE(done.error().message.find("abandon()"), std::string::npos)
            << call.name << ": " << done.error().message;
        EXPECT_TRUE(call.run(gpu, view).ok()) << call.name;
    }
}

TEST_F(EveryCall, SaysThatThereIsNoContext) {
    const test::DrawnView view(gl_, inputs_->drawing);
    const GpuContext gpu = *gpu_;
    auto other = test::HeadlessGl::make(*std::make_unique<std::string>());
    ASSERT_NE(other, nullptr);
    other.reset();  // no context is current now
    for (const Call& call : inputs_->everyCall()) {
        const Status done = call.run(gpu, view);
        ASSERT_FALSE(done.ok()) << call.name;
        EXPECT_EQ(done.error().code, ErrorCode::Lost) << call.name << ": " << done.error().message;
    }
    context_->makeCurrent();
}

/// Destroys the value whose context is gone.
template <class T>
void forget(std::unique_ptr<T>& made) {
    made->abandon();
    made.reset();
}

TEST_F(EveryCall, OutlivesItsContext) {
    const auto kept = [](auto made) {
        using T = std::decay_t<decltype(*made)>;
        EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
        return std::make_unique<T>(std::move(*made));
    };
    const CallInputs& in = *inputs_;
    auto view = std::make_unique<test::DrawnView>(gl_, in.drawing);
    const runtime::GBuffer surfaces = view->surfaces;
    const runtime::Target target = view->target;
    auto volume = kept(GpuVolume::upload(*gpu_, in.volume));
    auto coming = kept(GpuUpload::start(*gpu_, in.volume));
    auto receivers = kept(ReceiverPass::create(*gpu_));
    auto media = kept(MediumPass::create(*gpu_));
    auto water = kept(LiveWater::create(*gpu_));
    ASSERT_TRUE(water->setHeights(in.water).ok() && water->setLight(in.light).ok());
    ASSERT_TRUE(water->updateCausticMap({.bottom = -1.4F, .layers = 2, .resolution = 32}).ok());
    auto live = kept(LiveBake::create(*gpu_, {.min = {-1, -1, -1.5F}, .voxels = {16, 16, 16}}));
    ASSERT_TRUE(live->update(*water).ok());
    auto bodies = kept(GpuIndexVolumes::upload(*gpu_, in.objects));
    auto bent = kept(BentRayPass::create(*gpu_));
    auto files = VolumeSequence::open(in.frames);
    ASSERT_TRUE(files.ok());
    GpuSequence frames(*gpu_, std::move(*files));
    ASSERT_TRUE(frames.at(0, WhenLate::Wait).ok());
    MediumOptions medium;
    medium.scattering[0] = 0.2F;
    const auto use = [&] {
        return std::vector<Status>{receivers->draw(surfaces, target, {{volume.get()}}),
                                   receivers->drawLit(surfaces, target, {LightSource::CausticMap, {}, water.get()}),
                                   media->draw(surfaces, target, {{volume.get()}}, medium),
                                   water->setHeights(in.water),
                                   water->updateCausticMap({.bottom = -1.4F, .layers = 2, .resolution = 32}),
                                   water->drawGodRays(surfaces, target),
                                   live->update(*water),
                                   bent->draw(surfaces, target, *bodies, {{}}, {})};
    };
    for (const Status& done : use()) EXPECT_TRUE(done.ok());
    view.reset();
    context_.reset();
    for (const Status& done : use()) {
        ASSERT_FALSE(done.ok());
        EXPECT_EQ(done.error().code, ErrorCode::Lost) << done.error().message;
    }
    const auto taken = coming->take();
    ASSERT_FALSE(taken.ok());
    EXPECT_EQ(taken.error().code, ErrorCode::Lost);
    // Another context, in which the old one's names may be something else's.
    open(test::GlApi::Core45);
    if (IsSkipped()) return;
    makeContext();
    GLuint others[8] = {};
    gl_.GenTextures(8, others);
    for (const GLuint name : others) gl_.BindTexture(GL_TEXTURE_2D, name);
    forget(volume), forget(coming), forget(receivers), forget(media), forget(water), forget(live), forget(bodies);
    forget(bent);
    frames.abandon();
    constexpr GLenum kNone = GL_NO_ERROR;
    GLint bound = 0;
    gl_.GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
    EXPECT_EQ(static_cast<GLuint>(bound), others[7]) << "nothing of the new context's was deleted";
    gl_.DeleteTextures(8, others);
    for (const Call& call : in.everyCall()) drawn(call, *gpu_);
    EXPECT_EQ(gl_.firstError(), kNone);
}

}  // namespace
}  // namespace photic::runtime
