// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/method_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "bake/report/error.h"
#include "bake/scene/load_toml.h"

namespace photic {
namespace {

std::string inWords(const OptionValue& value) {
    return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

std::string wanted(const OptionSpec& spec) {
    const std::string unit = spec.unit.empty() ? "" : " " + spec.unit;
    switch (spec.type) {
        case OptionType::Flag:
            return "true or false";
        case OptionType::Integer:
            return fmt::format("a whole number from {:.0f} to {:.0f}{}", spec.min, spec.max, unit);
        case OptionType::Number:
            return fmt::format("a number from {:g} to {:g}{}", spec.min, spec.max, unit);
        case OptionType::Choice:
            break;
    }
    return fmt::format("one of \"{}\"", fmt::join(spec.choices, "\", \""));
}

// Whole numbers may be written as 4e6, which TOML reads as a float.
bool fits(const OptionSpec& spec, const OptionValue& value) {
    const auto* whole = std::get_if<std::int64_t>(&value);
    const auto* real = std::get_if<double>(&value);
    switch (spec.type) {
        case OptionType::Flag:
            return std::holds_alternative<bool>(value);
        case OptionType::Integer:
        case OptionType::Number: {
            if (!whole && !real) return false;
            const double x = whole ? static_cast<double>(*whole) : *real;
            return std::isfinite(x) && x >= spec.min && x <= spec.max &&
                   (spec.type == OptionType::Number || x == std::floor(x));
        }
        case OptionType::Choice:
            break;
    }
    const auto* text = std::get_if<std::string>(&value);
    return text && std::find(spec.choices.begin(), spec.choices.end(), *text) != spec.choices.end();
}

}  // namespace

void checkOptions(const std::string& method, std::span<const OptionSpec> specs, const GivenOptions& given) {
    std::vector<std::string> known;
    for (const OptionSpec& spec : specs) known.push_back(spec.name);
    for (const auto& entry : given) {
        const std::string& name = entry.first;
        const GivenOption& option = entry.second;
        const auto spec = std::find_if(specs.begin(), specs.end(), [&](const OptionSpec& s) { return s.name == name; });
        if (spec == specs.end()) {
            const std::string nearest = nearestName(name, known);
            const std::string hint = !nearest.empty() ? fmt::format("did you mean '{}'?", nearest)
                                     : known.empty()  ? std::string("it has none")
                                                      : fmt::format("it has {}", fmt::join(known, ", "));
            throw Error(ErrorCode::Input, fmt::format("method '{}' has no option '{}'; {}", method, name, hint),
                        option.where);
        }
        if (!fits(*spec, option.value)) {
            std::string hint;
            if (spec->type == OptionType::Choice && std::holds_alternative<std::string>(option.value)) {
                const std::string nearest = nearestName(std::get<std::string>(option.value), spec->choices);
                if (!nearest.empty()) hint = fmt::format("; did you mean \"{}\"?", nearest);
            }
            throw Error(option.where == "--set" ? ErrorCode::Usage : ErrorCode::Input,
                        fmt::format("option '{}' of method '{}' is {}; give {}{}", name, method, inWords(option.value),
                                    wanted(*spec), hint),
                        option.where);
        }
    }
}

void validateOptions(const Method& method, const GivenOptions& given) {
    checkOptions(method.name, method.options, given);
}

}  // namespace photic
