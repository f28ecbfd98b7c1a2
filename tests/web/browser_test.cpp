// SPDX-License-Identifier: Apache-2.0
// A page in a real browser, drawn by its software renderer: what its shaders look up, and what hands do to it.
#include <gtest/gtest.h>
#include <photic/runtime.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "bake/image/image.h"
#include "tests/cli/program.h"

namespace photic::test {
namespace {

using nlohmann::json;

bool hasChromium() { return std::system("chromium --version >/dev/null 2>&1") == 0; }

/// Runs the body of an async function in the page of a folder, once it has started. It returns what becomes JSON.
json inBrowser(const Workplace& place, const std::string& folder, const std::string& body) {
    std::string html = place.read(folder + "/index.html");
    const std::string end = "</body>";
    html.insert(html.rfind(end), R"(<script>
addEventListener("load", async () => {
    const result = document.createElement("pre");
    try {
        await photic.started;
        result.textContent = "RESULT" + JSON.stringify(await (async () => { )" +
                                     body + R"( })()) + "END";
    } catch (error) { result.textContent = "RESULT" + JSON.stringify({ error: String(error) }) + "END"; }
    document.body.append(result);
});
</script>
)");
    place.write(folder + "/test.html", html);
    const std::string page = (place / (folder + "/test.html")).string(), out = (place / "dom.txt").string();
    const std::string command =
        "timeout 300 chromium --headless --no-sandbox --disable-gpu-sandbox --use-angle=swiftshader "
        "--enable-unsafe-swiftshader --window-size=480,360 --virtual-time-budget=60000 --user-data-dir='" +
        (place / "profile").string() + "' --dump-dom 'file://" + page + "' >'" + out + "' 2>/dev/null";
    if (std::system(command.c_str()) != 0) return {{"error", "chromium failed"}};
    const std::string dom = place.read("dom.txt");
    const auto begin = dom.rfind("RESULT"), finish = dom.rfind("END");
    if (begin == std::string::npos || finish == std::string::npos) return {{"error", dom.substr(0, 4000)}};
    return json::parse(dom.substr(begin + 6, finish - begin - 6));
}

/// A pool's page, and its volume for the run-time library.
void makePage(const Workplace& place, const PoolText& pool) {
    place.write("pool.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    ASSERT_EQ(photic(place, {"export", "pool.vdb", "--scene", "pool.toml", "--web", "page", "-q"}).code, 0);
    ASSERT_EQ(photic(place, {"export", "pool.vdb", "-o", "pool.nvdb", "--precision", "float", "-q"}).code, 0);
}

/// Points in and around the pool, with normals.
std::vector<std::array<double, 6>> scattered(int count) {
    std::vector<std::array<double, 6>> points;
    for (int i = 0; i < count; ++i) {
        const auto part = [&](double irrational) { return std::fmod((i + 0.5) * irrational, 1.0); };
        const double up = 2 * part(0.7548776662) - 1, around = 6.283185307 * part(0.5698402910),
                     side = std::sqrt(1 - up * up);
        points.push_back({2.2 * part(0.8191725134) - 1.1, 2.2 * part(0.6710436067) - 1.1,
                          1.2 * part(0.5497004779) - 1.1, side * std::cos(around), side * std::sin(around), up});
    }
    return points;
}

class Browser : public testing::TestWithParam<const char*> {
protected:
    void SetUp() override {
        if (!hasChromium()) GTEST_SKIP() << "chromium is not installed (scripts/setup web)";
    }
};

TEST_P(Browser, LooksUpWhatTheRuntimeDoes) {
    const Workplace place;
    PoolText pool;
    pool.extra = GetParam();
    makePage(place, pool);
    const auto volume = runtime::loadVolume((place / "pool.nvdb").string());
    ASSERT_TRUE(volume) << volume.error().message;
    const auto points = scattered(400);
    const json got = inBrowser(place, "page", "return photic.measure(" + json(points).dump() + ");");
    ASSERT_TRUE(got.is_array()) << got;
    double apart = 0, sum = 0, face_apart = 0, face_sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& p = points[i];
        const runtime::Vec3 at{float(p[0]), float(p[1]), float(p[2])}, normal{float(p[3]), float(p[4]), float(p[5])};
        const runtime::Light light = volume->sample(at);
        const runtime::Vec3 face = volume->irradiance(at, normal);
        const double irradiance[] = {light.irradiance.x, light.irradiance.y, light.irradiance.z};
        const double faces[] = {face.x, face.y, face.z};
        for (std::size_t c = 0; c < 3; ++c) {
            apart += std::fabs(got[i]["irradiance"][c].get<double>() - irradiance[c]), sum += irradiance[c];
            face_apart += std::fabs(got[i]["face"][c].get<double>() - faces[c]), face_sum += faces[c];
        }
    }
    ASSERT_GT(sum, 0);
    RecordProperty("relative_l1", std::to_string(apart / sum));
    std::printf("look-ups in the browser against the run-time library: relative L1 %.2g, of faces %.2g\n", apart / sum,
                face_apart / face_sum);
    EXPECT_LT(apart / sum, 0.01);
    EXPECT_LT(face_apart / face_sum, 0.01);
}

// White and coloured, and light that opposes itself: a second sun, from the other side.
INSTANTIATE_TEST_SUITE_P(
    Colours, Browser,
    testing::Values("", "[medium]\nscattering = 0.05\nabsorption = [0.35, 0.07, 0.02]\n",
                    "[[light]]\ntype = \"sun\"\ndirection = [-0.8, 0.1, -0.6]\nirradiance = 800.0\n"));

class PageInBrowser : public Browser {};

TEST_P(PageInBrowser, FloorIsThatOfThePicture) {
    const Workplace place;
    makePage(place, {});
    ASSERT_EQ(
        photic(place, {"picture", "pool.toml", "pool.vdb", "--receiver", "floor", "--resolution", "64", "-q"}).code, 0);
    const Image floor = readExr((place / "pool_floor.exr").string());
    json points = json::array();
    for (int y = 0; y < floor.height; ++y)
        for (int x = 0; x < floor.width; ++x)
            points.push_back({-1 + 2 * (x + 0.5) / floor.width, 1 - 2 * (y + 0.5) / floor.height, -1.0, 0, 0, 1});
    const json got = inBrowser(place, "page", "return photic.measure(" + points.dump() + ");");
    ASSERT_TRUE(got.is_array()) << got;
    double apart = 0, sum = 0;
    for (int y = 0; y < floor.height; ++y) {
        for (int x = 0; x < floor.width; ++x) {
            const auto i = static_cast<std::size_t>(y * floor.width + x);
            apart += std::fabs(got[i]["face"][0].get<double>() - double(floor.at(x, y, 0)));
            sum += double(floor.at(x, y, 0));
        }
    }
    std::printf("floor in the browser against photic picture: relative L1 %.2g\n", apart / sum);
    EXPECT_LT(apart / sum, 0.02);
}

// What the pixels of the page are, how many of two pictures differ, and what a finger does.
constexpr const char* kPixels = R"(
const pixels = () => {
    photic.view.draw(photic);
    const gl = photic.view.gl, { width, height } = photic.view.canvas, bytes = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
};
const transformed = (m, p) => [0, 1, 2, 3].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);
const differing = (a, b) => a.reduce((count, byte, i) => count + (Math.abs(byte - b[i]) > 10 ? 1 : 0), 0) / a.length;
const finger = (kind, x, y, id = 1) => photic.view.canvas.dispatchEvent(new PointerEvent(kind,
    { clientX: x, clientY: y, pointerId: id, pointerType: "touch", button: 0, bubbles: true }));
const ballOnScreen = () => {
    const m = photic.camera.matrix(photic.view.canvas.clientWidth / photic.view.canvas.clientHeight), c = photic.ball.centre;
    const at = [0, 1, 2, 3].map((row) => m[row] * c[0] + m[4 + row] * c[1] + m[8 + row] * c[2] + m[12 + row]);
    return [(at[0] / at[3] + 1) / 2 * photic.view.canvas.clientWidth, (1 - at[1] / at[3]) / 2 * photic.view.canvas.clientHeight];
};
)";

TEST_P(PageInBrowser, IsDrawnAndTheBallIsDraggedThroughTheLight) {
    const Workplace place;
    makePage(place, {});
    const json got = inBrowser(place, "page", std::string(kPixels) + R"(
        const first = pixels(), start = [...photic.ball.centre];
        const bright = first.filter((byte, i) => i % 4 < 3 && byte > 128).length / first.length;
        const [x, y] = ballOnScreen();
        finger("pointerdown", x, y); finger("pointermove", x + 20, y + 5); finger("pointermove", x + 45, y + 10); finger("pointerup", x + 45, y + 10);
        const moved = pixels(), [nx, ny] = ballOnScreen();
        const eye = [...photic.camera.eye];
        finger("pointerdown", 20, 300); finger("pointermove", 120, 300); finger("pointerup", 120, 300);
        const turned = photic.camera.eye, distance = photic.camera.distance;
        finger("pointerdown", 20, 300); finger("pointerdown", 120, 300, 2); finger("pointermove", 320, 300, 2);
        finger("pointerup", 20, 300); finger("pointerup", 320, 300, 2);
        return { error: photic.view.gl.getError(), bright, changed: differing(first, moved), start, centre: photic.ball.centre,
                 screen: [nx - x, ny - y], eye, turned, pinch: photic.camera.distance / distance,
                 message: document.getElementById("message").hidden };)");
    ASSERT_FALSE(got.contains("error") && got["error"].is_string()) << got;
    EXPECT_EQ(got["error"], 0);
    EXPECT_TRUE(got["message"].get<bool>()) << "the page says that it is loading, or what failed";
    EXPECT_GT(got["bright"], 0.02) << "something is lit";
    EXPECT_LT(got["bright"], 0.7) << "and not everything";
    EXPECT_NEAR(got["screen"][0].get<double>(), 45, 2) << "the ball follows the finger";
    EXPECT_NEAR(got["screen"][1].get<double>(), 10, 2);
    EXPECT_GT(got["changed"], 0.002) << "and the picture with it";
    EXPECT_NE(got["eye"], got["turned"]);
    EXPECT_LT(got["pinch"], 0.6) << "two fingers that part come nearer";
}

TEST_P(PageInBrowser, SunlightThatMetNothingIsStoppedByMirrors) {
    const Workplace place;
    place.write("room.toml", R"(photic = 1
[domain]
min = [-1, -1, -0.1]
max = [1, 1, 1]
resolution = 48
[[light]]
type = "sun"
direction = [0.5, 0, -0.8660254]
irradiance = 1000.0
[[surface]]
name = "ball"
kind = "sphere"
position = [0, 0, 0.5]
radius = 0.2
event = "mirror"
colour = 0.0001
[[object]]
name = "floor"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }
)");
    const Outcome baked = photic(place, {"bake", "room.toml"});
    ASSERT_EQ(baked.code, 0) << baked.err;
    ASSERT_EQ(photic(place, {"export", "room.vdb", "--scene", "room.toml", "--web", "page", "-q"}).code, 0);
    // The shadow's middle lies at 0.5 tan 30 degrees; its rim 0.2 beside it, across the light.
    const json got = inBrowser(place, "page", std::string(kPixels) + R"(
        photic.camera.rise = 1.45; photic.ball.centre = [-0.8, -0.8, 0.9];
        const bytes = pixels(), { width, height } = photic.view.canvas;
        const m = photic.camera.matrix(photic.view.canvas.clientWidth / photic.view.canvas.clientHeight);
        return [[0.289, 0, 0], [0.289, 0.15, 0], [0.289, 0.26, 0], [-0.5, 0.3, 0]].map((p) => {
            const at = transformed(m, [...p, 1]);
            const x = Math.round((at[0] / at[3] + 1) / 2 * width), y = Math.round((at[1] / at[3] + 1) / 2 * height);
            return bytes[4 * (y * width + x) + 1];
        });)");
    ASSERT_TRUE(got.is_array()) << got;
    EXPECT_GT(got[3], 120) << "lit";
    EXPECT_LT(got[0], got[3].get<int>() / 2);
    EXPECT_LT(got[1], got[3].get<int>() / 2) << "within the shadow";
    EXPECT_NEAR(got[2].get<int>(), got[3].get<int>(), 12) << "beside it";
}

TEST_P(PageInBrowser, ColouredGlassTintsByTheWayInIt) {
    const Workplace place;
    place.write("room.toml", R"(photic = 1
[domain]
min = [-1, -1, -0.1]
max = [1, 1, 1]
resolution = 32
[[light]]
type = "sun"
direction = [0, 0, -1]
irradiance = 1000.0
[[medium]]
name = "wine"
ior = 1.345
absorption = [1, 10, 30]
[[surface]]
name = "ball"
kind = "sphere"
position = [0, 0, 0.5]
radius = 0.2
inside = "wine"
[[object]]
name = "floor"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }
[[camera]]
position = [0, -3, 0.5]
target = [0, 0, 0.5]
)");
    const Outcome baked = photic(place, {"bake", "room.toml"});
    ASSERT_EQ(baked.code, 0) << baked.err;
    ASSERT_EQ(photic(place, {"export", "room.vdb", "--scene", "room.toml", "--web", "page", "-q"}).code, 0);
    // Through the middle, half way out, beside it, and through the middle with the page's own ball in there.
    const json got = inBrowser(place, "page", std::string(kPixels) + R"(
        const { gl } = photic.view;
        const depths = (x) => {
            pixels();
            const { width, height } = photic.view.canvas, m = photic.camera.matrix(width / height), at = transformed(m, [x, 0, 0.5, 1]);
            gl.bindFramebuffer(gl.FRAMEBUFFER, photic.view.way.frame);
            const read = new Float32Array(4);
            gl.readPixels(Math.round((at[0] / at[3] + 1) / 2 * width), Math.round((at[1] / at[3] + 1) / 2 * height), 1, 1, gl.RGBA, gl.FLOAT, read);
            return [...read.slice(0, 3)];
        };
        photic.ball.centre = [-0.8, -0.8, 0.9];
        const seen = [depths(0), depths(0.1), depths(0.3)];
        photic.ball.centre = [0, 0, 0.5]; photic.ball.radius = 0.1;
        return [...seen, depths(0)];)");
    ASSERT_TRUE(got.is_array()) << got;
    const double ways[] = {0.4, 2 * std::sqrt(0.2 * 0.2 - 0.1 * 0.1), 0, 0.1}, absorption[] = {1, 10, 30};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(got[i][c].get<double>(), ways[i] * absorption[c], 0.01 * absorption[c]) << i << ", " << c;
}

TEST_P(PageInBrowser, PlaysItsFrames) {
    const Workplace place;
    PoolText pool;
    pool.surface = "bump = { height = 0.1, radius = 0.2, speed = 1.0 }";
    std::string text = pool.text();
    text.insert(text.find('\n') + 1, "frame_rate = 12.0\n");
    place.write("pool.toml", text);
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "--frames", "1-3"}).code, 0);
    ASSERT_EQ(photic(place, {"export", "pool.0001.vdb", "pool.0002.vdb", "pool.0003.vdb", "--scene", "pool.toml",
                             "--web", "page", "-q"})
                  .code,
              0);
    const json got = inBrowser(place, "page", std::string(kPixels) + R"(
        const shown = [];
        for (const time of [0, 0.5, 1, 2]) { await photic.setTime(time); shown.push(pixels()); }
        return { line: !document.getElementById("time").hidden, label: document.getElementById("moment_value").textContent,
                 steps: [differing(shown[0], shown[1]), differing(shown[1], shown[2]), differing(shown[2], shown[3])],
                 whole: differing(shown[0], shown[3]) };)");
    ASSERT_TRUE(got.contains("steps")) << got;
    EXPECT_TRUE(got["line"].get<bool>());
    EXPECT_EQ(got["label"], "frame 3");
    for (const auto& step : got["steps"]) EXPECT_GT(step, 0.0001);
    EXPECT_GT(got["whole"], got["steps"][0]);
}

TEST_P(PageInBrowser, SaysWhatIsMissing) {
    const Workplace place;
    makePage(place, {});
    std::filesystem::remove(place / "page/frame.0000.js");
    const json got = inBrowser(place, "page", "return 1;");
    ASSERT_TRUE(got.contains("error")) << got;
    EXPECT_NE(got["error"].get<std::string>().find("keep all files of this page in one folder"), std::string::npos)
        << got;
}

INSTANTIATE_TEST_SUITE_P(OfAPool, PageInBrowser, testing::Values(""));

}  // namespace
}  // namespace photic::test
