// SPDX-License-Identifier: Apache-2.0
#include "bake/methods/catalogue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "bake/methods/method_options.h"
#include "bake/report/error.h"
#include "bake/scene/setting_names.h"
#include "tests/methods/photon_scenes.h"

namespace photic {
namespace {

enum class Colour { Red, Blue };

struct Toy {
    bool fast = true;
    int steps = 3;
    std::int64_t many = 4000000000;
    double width = 0.5;
    Colour colour = Colour::Blue;
};

const std::vector<OptionBinding<Toy>> kToy{
    bindOption("fast", &Toy::fast, "a switch"),
    bindOption("steps", &Toy::steps, {1, 10}, "", "a whole number"),
    bindOption("many", &Toy::many, {0, 1e10}, "paths", "a large one"),
    bindOption("width", &Toy::width, {0, 1}, "m", "a number"),
    bindOption<Toy, Colour>("colour", &Toy::colour, {{"red", Colour::Red}, {"blue", Colour::Blue}}, "a choice"),
};

Toy given(const GivenOptions& options) {
    Toy toy;
    applyOptions<Toy>("toy", toy, kToy, options);
    return toy;
}

std::string complaint(const std::string& name, const OptionValue& value) {
    try {
        given({{name, {value, "scene.toml:7"}}});
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Input);
        EXPECT_EQ(error.where(), "scene.toml:7");
        return error.what();
    }
    return {};
}

::testing::AssertionResult has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos ? ::testing::AssertionSuccess()
                                                : ::testing::AssertionFailure() << "\"" << text << "\" lacks " << part;
}

TEST(MethodOptions, DefaultsComeFromTheStruct) {
    const auto specs = optionSpecs<Toy>(kToy);
    ASSERT_EQ(specs.size(), 5u);
    EXPECT_EQ(specs[0].default_value, OptionValue(true));
    EXPECT_EQ(specs[1].default_value, OptionValue(std::int64_t{3}));
    EXPECT_EQ(specs[2].default_value, OptionValue(std::int64_t{4000000000}));
    EXPECT_EQ(specs[3].default_value, OptionValue(0.5));
    EXPECT_EQ(specs[4].default_value, OptionValue(std::string("blue")));
    EXPECT_EQ(specs[1].type, OptionType::Integer);
    EXPECT_EQ(specs[3].type, OptionType::Number);
    EXPECT_EQ(specs[3].unit, "m");
    EXPECT_EQ(specs[4].choices, (std::vector<std::string>{"red", "blue"}));
}

TEST(MethodOptions, GivenValuesAreWritten) {
    const Toy toy = given({{"fast", {false, ""}},
                           {"steps", {std::int64_t{7}, ""}},
                           {"width", {std::int64_t{1}, ""}},
                           {"colour", {std::string("red"), ""}},
                           {"many", {5e9, ""}}});
    EXPECT_FALSE(toy.fast);
    EXPECT_EQ(toy.steps, 7);
    EXPECT_EQ(toy.width, 1.0);
    EXPECT_EQ(toy.many, 5000000000) << "5e9 is a whole number";
    EXPECT_EQ(toy.colour, Colour::Red);
    EXPECT_EQ(given({}).steps, 3);
}

TEST(MethodOptions, BadOnesAreExplained) {
    EXPECT_TRUE(has(complaint("stepps", std::int64_t{3}), "did you mean 'steps'"));
    EXPECT_TRUE(has(complaint("xylophone", std::int64_t{3}), "it has fast, steps, many, width, colour"));
    EXPECT_TRUE(has(complaint("steps", std::int64_t{11}), "from 1 to 10"));
    EXPECT_TRUE(has(complaint("steps", std::int64_t{11}), "is 11"));
    EXPECT_TRUE(has(complaint("steps", 2.5), "whole number"));
    EXPECT_TRUE(has(complaint("steps", std::string("three")), "whole number"));
    EXPECT_TRUE(has(complaint("width", std::numeric_limits<double>::quiet_NaN()), "from 0 to 1 m"));
    EXPECT_TRUE(has(complaint("width", -0.1), "from 0 to 1 m"));
    EXPECT_TRUE(has(complaint("width", true), "from 0 to 1 m"));
    EXPECT_TRUE(has(complaint("fast", std::int64_t{1}), "true or false"));
    EXPECT_TRUE(has(complaint("colour", std::string("bleu")), "did you mean \"blue\""));
    EXPECT_TRUE(has(complaint("colour", std::string("bleu")), "\"red\", \"blue\""));
}

TEST(Catalogue, RowsAreComplete) {
    ASSERT_FALSE(methodCatalogue().empty());
    for (const Method& m : methodCatalogue()) {
        EXPECT_FALSE(m.name.empty());
        EXPECT_FALSE(m.summary.empty()) << m.name;
        EXPECT_FALSE(m.grids.empty()) << m.name;
        EXPECT_NE(m.refusal, nullptr) << m.name;
        EXPECT_NE(m.bake, nullptr) << m.name;
        EXPECT_NE(m.cost, nullptr) << m.name;
        for (const std::string& grid : m.grids) {
            GridSet set = kNoGrids;
            EXPECT_TRUE(wantGrid(set, grid)) << m.name << " makes an unknown grid " << grid;
            EXPECT_FALSE(set.density) << m.name << ": every volume may have density";
        }
        GivenOptions defaults;
        for (const OptionSpec& o : m.options) {
            EXPECT_FALSE(o.help.empty()) << m.name << '.' << o.name;
            EXPECT_EQ(o.type == OptionType::Choice, !o.choices.empty()) << m.name << '.' << o.name;
            defaults[o.name] = {o.default_value, "default"};
        }
        EXPECT_NO_THROW(validateOptions(m, defaults)) << m.name;
    }
}

TEST(Catalogue, MethodsAreChosenByName) {
    const Scene scene = test_scenes::waterScene(0.3);
    EXPECT_EQ(chooseMethod("photons", scene).name, "photons");
    EXPECT_EQ(&chooseMethod("auto", scene), &methodCatalogue().front());
    const auto message = [&](const std::string& name, const Scene& s) -> std::string {
        try {
            chooseMethod(name, s);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
            return error.what();
        }
        return {};
    };
    EXPECT_TRUE(has(message("photon", scene), "did you mean 'photons'"));
    EXPECT_TRUE(has(message("xylophone", scene), "photons"));
    for (const Method& m : methodCatalogue()) {
        Scene asked = scene;
        asked.bake.grids.arrival_time = true;
        const bool makes = std::find(m.grids.begin(), m.grids.end(), "arrival_time") != m.grids.end();
        EXPECT_EQ(has(message(m.name, asked), "makes no grid 'arrival_time'"), !makes) << m.name;
    }
    Scene dark = scene;
    dark.lights.clear();
    EXPECT_TRUE(has(message("photons", dark), "no [[light]]"));
    for (const Method& m : methodCatalogue()) EXPECT_TRUE(has(message("auto", dark), m.name + ": "));
}

}  // namespace
}  // namespace photic
