// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/catalogue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <string>

#include "bake/cli/json.h"
#include "bake/cli/verbs.h"

namespace photic::cli {

namespace {

constexpr const char* kTypeNames[] = {"flag", "integer", "number", "choice"};

bool hasRange(const OptionSpec& option) {
    return option.type == OptionType::Integer || option.type == OptionType::Number;
}

Json methodJson(const Method& method) {
    Json options = Json::array();
    for (const OptionSpec& option : method.options) {
        Json json{{"name", option.name},
                  {"type", kTypeNames[static_cast<int>(option.type)]},
                  {"unit", option.unit},
                  {"default", toJson(option.default_value)}};
        if (hasRange(option)) {
            json["min"] = option.min;
            json["max"] = option.max;
        }
        if (option.type == OptionType::Choice) json["choices"] = option.choices;
        json["help"] = option.help;
        options.push_back(std::move(json));
    }
    return {{"name", method.name},
            {"summary", method.summary},
            {"grids", gridsOf(method)},
            {"standard_error", method.standard_error == StandardError::PerVoxel},
            {"options", options}};
}

}  // namespace

int run(const MethodsArguments& arguments, Terminal&) {
    if (arguments.json) {
        Json methods = Json::array();
        for (const Method& method : methodCatalogue()) methods.push_back(methodJson(method));
        print({{"schema", "photic-methods-1"}, {"methods", methods}});
        return 0;
    }
    std::string text;
    for (const Method& method : methodCatalogue()) {
        text += fmt::format("{}: {}\n  grids: {}\n", method.name, method.summary, fmt::join(gridsOf(method), ", "));
        if (method.standard_error == StandardError::PerVoxel) text += "  knows its standard error per voxel\n";
        for (const OptionSpec& option : method.options) {
            text += fmt::format("  {} = {}{}", option.name, toJson(option.default_value).dump(),
                                option.unit.empty() ? "" : " " + option.unit);
            if (hasRange(option)) text += fmt::format(" ({} to {})", option.min, option.max);
            if (option.type == OptionType::Choice) text += fmt::format(" ({})", fmt::join(option.choices, ", "));
            text += fmt::format("\n      {}\n", option.help);
        }
    }
    std::fputs(text.c_str(), stdout);
    return 0;
}

}  // namespace photic::cli
