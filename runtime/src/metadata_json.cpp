// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/metadata_json.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

#include "runtime/format/light_volume_format.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

/// One value: the numbers of a number or of a flat array (the first three), or a text.
struct Value {
    std::array<double, 3> numbers{};
    int count = 0;  ///< of numbers
    std::string text;
};

class Reader {
public:
    explicit Reader(std::string_view json) : rest_(json) {}

    /// Calls body(key, value) for each member of the object.
    template <class Body>
    void object(const Body& body) {
        expect('{');
        if (accept('}')) return;
        do {
            const std::string key = text();
            expect(':');
            Value value;
            read(value, 0);
            body(key, value);
        } while (accept(','));
        expect('}');
    }

private:
    [[noreturn]] static void damaged() {
        fail(ErrorCode::Format, "the metadata are no JSON object; the file is damaged");
    }

    void skipSpace() {
        const std::size_t start = rest_.find_first_not_of(" \t\r\n");
        rest_.remove_prefix(start == std::string_view::npos ? rest_.size() : start);
    }
    bool accept(char c) {
        skipSpace();
        if (rest_.empty() || rest_.front() != c) return false;
        rest_.remove_prefix(1);
        return true;
    }
    void expect(char c) {
        if (!accept(c)) damaged();
    }

    /// Escapes are kept but for the character that they protect: no text that is looked at has any.
    std::string text() {
        expect('"');
        std::string out;
        while (true) {
            if (rest_.empty()) damaged();
            char c = rest_.front();
            rest_.remove_prefix(1);
            if (c == '"') return out;
            if (c == '\\') {
                if (rest_.empty()) damaged();
                c = rest_.front();
                rest_.remove_prefix(1);
            }
            out.push_back(c);
        }
    }

    void number(Value& value) {
        double v = 0;
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), v);
        if (error == std::errc::invalid_argument) damaged();
        if (error != std::errc{}) v = HUGE_VAL;
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        if (value.count < 3) value.numbers[static_cast<std::size_t>(value.count)] = v;
        ++value.count;
    }

    bool word(std::string_view w) {
        if (rest_.substr(0, w.size()) != w) return false;
        rest_.remove_prefix(w.size());
        return true;
    }

    void read(Value& value, int depth) {
        constexpr int kDeepest = 16;
        if (depth > kDeepest) damaged();
        skipSpace();
        if (rest_.empty()) damaged();
        if (rest_.front() == '"') {
            value.text = text();
        } else if (accept('[')) {
            if (accept(']')) return;
            do {
                read(value, depth + 1);
            } while (accept(','));
            expect(']');
        } else if (accept('{')) {
            Value inner;  // what is nested is not looked at
            if (accept('}')) return;
            do {
                text();
                expect(':');
                read(inner, depth + 1);
            } while (accept(','));
            expect('}');
        } else if (!word("true") && !word("false") && !word("null")) {
            number(value);
        }
    }

    std::string_view rest_;
};

/// A number, or three.
Vec3 vectorOf(const Value& value, const std::string& key) {
    if (value.count == 3) return {value.numbers[0], value.numbers[1], value.numbers[2]};
    if (value.count == 1) return {value.numbers[0], value.numbers[0], value.numbers[0]};
    fail(ErrorCode::Format, "the metadata's '" + key + "' is neither one number nor three");
}

double numberOf(const Value& value, const std::string& key) {
    if (value.count != 1) fail(ErrorCode::Format, "the metadata's '" + key + "' is no number");
    return value.numbers[0];
}

void require(bool sensible, const std::string& key, const char* range) {
    if (!sensible) fail(ErrorCode::Format, "the metadata's '" + key + "' is not " + range);
}

bool inRange(const Vec3& v, double low, double high) {
    for (const double c : {v.x, v.y, v.z}) {
        if (!(c >= low && c <= high)) return false;
    }
    return true;
}

void set(Metadata& m, const std::string& key, const Value& value) {
    if (key == "version") {
        const double version = numberOf(value, key);
        if (!(version >= 1 && version <= format::kVersion)) {
            fail(ErrorCode::Format, "the light volume's format is version " + std::to_string(version) +
                                        "; this library reads up to " + std::to_string(format::kVersion) +
                                        ": update it");
        }
        m.version = static_cast<int>(version);
    } else if (key == "reference_irradiance") {
        m.reference_irradiance = numberOf(value, key);
        require(m.reference_irradiance > 0 && m.reference_irradiance < 1e30, key, "above 0 and below 1e30 W/m2");
    } else if (key == "ior") {
        m.ior = numberOf(value, key);
        require(m.ior >= 0.1 && m.ior <= 100, key, "between 0.1 and 100");
    } else if (key == "anisotropy") {
        m.anisotropy = numberOf(value, key);
        require(std::fabs(m.anisotropy) < 1, key, "between -1 and 1");
    } else if (key == "scattering" || key == "absorption") {
        Vec3& v = key == "scattering" ? m.scattering : m.absorption;
        v = vectorOf(value, key);
        require(inRange(v, 0, 1e9), key, "between 0 and 1e9 1/m");
    } else if (key == "frame") {
        const double frame = numberOf(value, key);
        require(std::fabs(frame) < 2e9, key, "a frame's number");
        m.frame = static_cast<int>(frame);
    } else if (key == "period") {
        m.period = vectorOf(value, key);
        require(inRange(m.period, 0, 1e9), key, "between 0 and 1e9 m");
    } else if (key == "water_level") {
        m.surface[3] = numberOf(value, key);
        require(std::fabs(m.surface[3]) < 1e9, key, "between -1e9 and 1e9 m");
    } else if (key == "scene_hash") {
        m.scene_hash = value.text;
    } else if (key == "up_axis") {
        m.up_axis = value.text;
    } else if (key == "coarse_blocks") {
        m.coarse_blocks = value.text;
    } else if (key == "paths") {
        m.paths = value.text;
    }
}

}  // namespace

Metadata readMetadata(std::string_view json) {
    Metadata metadata;
    Reader(json).object([&](const std::string& key, const Value& value) { set(metadata, key, value); });
    if (metadata.up_axis == "Y") std::swap(metadata.surface[1], metadata.surface[2]);
    return metadata;
}

}  // namespace photic::runtime
