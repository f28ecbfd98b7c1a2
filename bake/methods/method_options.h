// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bake/methods/catalogue.h"

namespace photic {

/// One option of a method, tied to a field of its options struct S. The field's initialiser is the default.
template <class S>
struct OptionBinding {
    OptionSpec spec;
    std::function<void(S&, const OptionValue&)> assign;  ///< of a value that passed checkOption
};

/// Inclusive limits of a number.
struct OptionRange {
    double min, max;
};

/// A whole or real number: `T` is an integer or floating-point type.
template <class S, class T>
requires(std::is_arithmetic_v<T> &&
         !std::is_same_v<T, bool>) OptionBinding<S> bindOption(std::string name, T S::*field, OptionRange range,
                                                               std::string unit, std::string help) {
    constexpr bool whole = std::is_integral_v<T>;
    OptionBinding<S> b;
    b.spec = {std::move(name),
              whole ? OptionType::Integer : OptionType::Number,
              std::move(unit),
              {},
              range.min,
              range.max,
              {},
              std::move(help)};
    if constexpr (whole)
        b.spec.default_value = static_cast<std::int64_t>(S{}.*field);
    else
        b.spec.default_value = static_cast<double>(S{}.*field);
    b.assign = [field](S& s, const OptionValue& value) {
        s.*field = std::visit(
            [](const auto& v) -> T {
                if constexpr (std::is_arithmetic_v<std::decay_t<decltype(v)>>)
                    return static_cast<T>(v);
                else
                    return T{};
            },
            value);
    };
    return b;
}

/// A switch.
template <class S>
OptionBinding<S> bindOption(std::string name, bool S::*field, std::string help) {
    OptionBinding<S> b;
    b.spec = {std::move(name), OptionType::Flag, "", S{}.*field, 0, 0, {}, std::move(help)};
    b.assign = [field](S& s, const OptionValue& value) { s.*field = std::get<bool>(value); };
    return b;
}

/// One of several names: `T` is an enum.
template <class S, class T>
requires std::is_enum_v<T> OptionBinding<S> bindOption(std::string name, T S::*field,
                                                       std::vector<std::pair<std::string, T>> choices,
                                                       std::string help) {
    OptionBinding<S> b;
    b.spec = {std::move(name), OptionType::Choice, "", std::string(), 0, 0, {}, std::move(help)};
    for (const auto& [label, value] : choices) {
        b.spec.choices.push_back(label);
        if (value == S{}.*field) b.spec.default_value = label;
    }
    b.assign = [field, choices = std::move(choices)](S& s, const OptionValue& given) {
        for (const auto& [label, value] : choices)
            if (label == std::get<std::string>(given)) s.*field = value;
    };
    return b;
}

/// Checks every given option against the specs of `method`.
/// @throws Error{Input} naming the option's place, value, range and the nearest known name
void checkOptions(const std::string& method, std::span<const OptionSpec> specs, const GivenOptions& given);

/// The specs of a method's options, for its catalogue row.
template <class S>
std::vector<OptionSpec> optionSpecs(std::span<const OptionBinding<S>> bindings) {
    std::vector<OptionSpec> specs;
    for (const auto& b : bindings) specs.push_back(b.spec);
    return specs;
}

/// Checks the given options and writes them into `options`; fields that are not given keep their values.
/// @throws as checkOptions
template <class S>
void applyOptions(const std::string& method, S& options, std::span<const OptionBinding<S>> bindings,
                  const GivenOptions& given) {
    checkOptions(method, optionSpecs(bindings), given);
    for (const auto& b : bindings)
        if (const auto it = given.find(b.spec.name); it != given.end()) b.assign(options, it->second.value);
}

}  // namespace photic
