// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "bake/image/atomic_file.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/load_parts.h"

namespace photic {
namespace {

IndexVolume loadLayers(const TableReader& index) {
    std::vector<std::pair<double, double>> layers;
    for (const ConfigValue* value : tablesOf(index.find("layers"), "layers")) {
        const TableReader table(*value, "'layers'", {"z", "n"});
        const auto z = table.number("z", anyNumber("m"));
        if (!z) table.missing("z", "-1.5 [m]");
        const auto n = table.number("n", between(kLeastIndex, kLargestIndex));
        if (!n) table.missing("n", "1.34");
        for (const auto& layer : layers)
            if (layer.first == *z)
                table.fail("z", fmt::format("two layers lie at z = {} m; give each height once", *z));
        layers.emplace_back(*z, *n);
    }
    if (layers.empty()) index.fail("layers", "'layers' is empty; give at least one, for example { z = 0, n = 1.34 }");
    return layeredIndex(std::move(layers));
}

}  // namespace

std::shared_ptr<const IndexVolume> loadIndex(const ConfigValue& value, double medium, LoadContext& context) {
    const TableReader table(value, "[[index]]", {"file", "grid", "layers"}, {"name", "smooth", "gradient"});
    table.exclusive({"file", "layers"});
    table.exclusive({"grid", "layers"});
    if (table.has("layers")) return std::make_shared<IndexVolume>(loadLayers(table));
    const auto file = table.text("file");
    if (!file) table.missing("file", "\"water.vdb\", or layers = [{ z = 0, n = 1.333 }, { z = -1.5, n = 1.36 }]");
    const std::string path = context.path(*file);
    return placed(table, "file", [&] {
        const std::string bytes = readFileBytes(path);
        context.hashBytes(bytes);
        return std::make_shared<IndexVolume>(
            readIndexVolume(path, bytes, table.text("grid").value_or(""), medium, context.monitor));
    });
}

}  // namespace photic
