// SPDX-License-Identifier: Apache-2.0
#include "tests/stability/scene_model.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <utility>

#include "tests/support/blocked_light.h"

namespace photic::stability {
namespace {

std::string vector(const glm::dvec3& v) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x, v.y, v.z); }

// A mesh as an OBJ file; positions in metres.
void writeObj(const std::string& path, const std::vector<glm::dvec3>& positions,
              const std::vector<std::array<int, 3>>& triangles) {
    std::ofstream out(path);
    for (const glm::dvec3& p : positions) out << fmt::format("v {:.17g} {:.17g} {:.17g}\n", p.x, p.y, p.z);
    for (const auto& t : triangles) out << fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
}

class Writer {
public:
    Writer(const SceneModel& scene, std::string directory)
        : scene_(scene), directory_(std::move(directory)), offset_(glm::dvec3(scene.shift) * scene.voxelSize()) {}

    std::string text() {
        std::string out = fmt::format("photic = 1\n[domain]\nmin = {}\nmax = {}\nvoxel_size = {:.17g}\n",
                                      vector(place(scene_.low)), vector(place(scene_.high)), scene_.voxelSize());
        if (scene_.leaning) out += fmt::format("shear = \"light\"\nlayer_height = {:.17g}\n", 2 * scene_.voxelSize());
        for (const SceneModel::Lamp& l : scene_.lamps) out += lamp(l);
        if (scene_.water != SceneModel::Water::None) out += surface();
        for (std::size_t i = 0; i < scene_.glasses.size(); ++i) out += glass(scene_.glasses[i], i);
        if (scene_.index != SceneModel::Index::None) out += index();
        if (scene_.water != SceneModel::Water::None &&
            (scene_.absorption != glm::dvec3(0) || scene_.scattering != glm::dvec3(0)))
            out += fmt::format("[[medium]]\nname = \"water\"\nior = {:.17g}\nabsorption = {}\nscattering = {}\n",
                               scene_.ior_below, vector(scene_.absorption / scene_.scale),
                               vector(scene_.scattering / scene_.scale));
        for (std::size_t i = 0; i < scene_.things.size(); ++i) out += object(scene_.things[i], i);
        out += fmt::format("[bake]\nmethod = \"{}\"\nwhere = \"{}\"\nquadrature = {}\ntolerance = {:.17g}\n",
                           scene_.method, scene_.where, scene_.quadrature, scene_.tolerance);
        if (scene_.caustic) out += "grids = [\"irradiance\", \"direction\", \"caustic\"]\n";
        if (!scene_.options.empty()) out += fmt::format("[bake.{}]\n{}", scene_.method, scene_.options);
        return out;
    }

private:
    glm::dvec3 place(const glm::dvec3& p) const { return scene_.scale * p + offset_; }
    double length(double l) const { return scene_.scale * l; }

    std::string lamp(const SceneModel::Lamp& lamp) const {
        const glm::dvec3 light = lamp.irradiance * scene_.brightness;
        if (lamp.kind == SceneModel::LampKind::Sun)
            return fmt::format(
                "[[light]]\ntype = \"sun\"\ndirection = {}\nirradiance = {}\nangular_diameter = {:.17g}\n",
                vector(lamp.direction), vector(light), lamp.disc);
        const std::string power = vector(light * (scene_.scale * scene_.scale)),
                          place_of = vector(place(lamp.position));
        if (lamp.kind == SceneModel::LampKind::Rectangle)
            return fmt::format(
                "[[light]]\ntype = \"rectangle\"\ncenter = {}\ndirection = {}\nsize = [{:.17g}, {:.17g}]\n"
                "power = {}\nsamples = {}\n",
                place_of, vector(lamp.direction), length(lamp.size), length(0.5 * lamp.size), power, lamp.samples);
        std::string out = fmt::format("[[light]]\ntype = \"{}\"\nposition = {}\npower = {}\n",
                                      lamp.kind == SceneModel::LampKind::Point ? "point" : "spot", place_of, power);
        if (lamp.kind == SceneModel::LampKind::Spot)
            out += fmt::format("direction = {}\nangle = {:.17g}\nblend = {:.17g}\n", vector(lamp.direction), lamp.angle,
                               lamp.blend);
        return out;
    }

    std::string index() const {
        const glm::dvec3 low = place(scene_.index_center - scene_.index_radius),
                         high = place(scene_.index_center + scene_.index_radius), center = place(scene_.index_center);
        const double radius = length(scene_.index_radius);
        std::string kind;
        switch (scene_.index) {
            case SceneModel::Index::Luneburg:
                kind = fmt::format("kind = \"luneburg\", center = {}, radius = {:.17g}", vector(center), radius);
                break;
            case SceneModel::Index::FishEye:
                kind = fmt::format("kind = \"fish_eye\", center = {}, n0 = {:.17g}, scale = {:.17g}, radius = {:.17g}",
                                   vector(center), 1 + scene_.index_strength, radius / std::sqrt(scene_.index_strength),
                                   radius);
                break;
            case SceneModel::Index::Linear:
                kind =
                    fmt::format("kind = \"linear\", center = {}, n0 = 1.4, slope = [{:.17g}, 0, 0], min = {}, max = {}",
                                vector(center), scene_.index_strength / radius, vector(low), vector(high));
                break;
            default:
                kind = fmt::format(
                    "kind = \"salt\", level = {:.17g}, thickness = {:.17g}, n_above = 1.333, n_below = {:.17g}",
                    center.z, 0.3 * radius, 1.333 + scene_.index_strength);
        }
        std::string out = "[[medium]]\nname = \"body\"\nindex = { " + kind + " }\n";
        if (scene_.absorption != glm::dvec3(0))
            out += fmt::format("absorption = {}\n", vector(scene_.absorption / scene_.scale));
        return out;
    }

    std::string glass(const SceneModel::Glass& glass, std::size_t number) const {
        std::string out, body = fmt::format("[[surface]]\nname = \"glass {}\"\nevent = \"{}\"\nposition = {}\n", number,
                                            glass.event, vector(place(glass.center)));
        if (glass.event == "mirror")
            body += "colour = [0.9, 0.8, 0.7]\n";
        else if (!glass.thin) {
            out = fmt::format("[[medium]]\nname = \"glass {}\"\nior = {:.17g}\nabsorption = {}\npriority = {}\n",
                              number, glass.ior, vector(glass.absorption / scene_.scale), glass.priority);
            body += fmt::format("inside = \"glass {}\"\n", number);
        } else {
            body += fmt::format("thin = true\nior_below = {:.17g}\n", glass.ior);
        }
        if (glass.shape == SceneModel::GlassShape::Sphere)
            return out + body + fmt::format("kind = \"sphere\"\nradius = {:.17g}\n", length(0.5 * glass.size.x));
        const std::string file = fmt::format("glass_{}.obj", number);
        writeGlass(glass, directory_ + "/" + file);
        return out + body +
               fmt::format("kind = \"mesh\"\nfile = \"{}\"\nscale = {:.17g}\nrotation = {}\nsmooth = {}\n", file,
                           scene_.scale, vector(glass.rotation), !glass.facets);
    }

    // Around the origin, in units of the scene.
    static void writeGlass(const SceneModel::Glass& glass, const std::string& path) {
        if (glass.shape == SceneModel::GlassShape::Rock) {
            const truth::Triangles rock = truth::rock(glm::dvec3(0), glass.size.x, 1, glass.seed);
            return writeObj(path, rock.positions, rock.triangles);
        }
        std::vector<glm::dvec3> positions;
        std::vector<std::array<int, 3>> triangles;
        if (glass.shape == SceneModel::GlassShape::Pane) {
            for (int i = 0; i < 4; ++i)
                positions.push_back(glass.size.x * glm::dvec3((i & 1) - 0.5, (i >> 1) - 0.5, 0));
            triangles = {{0, 1, 3}, {0, 3, 2}};
            if (glass.inverted) triangles = {{0, 3, 1}, {0, 2, 3}};
        } else {
            for (int i = 0; i < 8; ++i)
                positions.push_back(glass.size * glm::dvec3((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2) - 0.5));
            triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                         {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
        }
        writeObj(path, positions, triangles);
    }

    std::string surface() const {
        std::string out =
            fmt::format("[[surface]]\nname = \"water\"\nevent = \"{}\"\nior_above = {:.17g}\nior_below = {:.17g}\n",
                        scene_.event, scene_.ior_above, scene_.ior_below);
        if (scene_.water == SceneModel::Water::Mesh) {
            writeWater();
            return out + "kind = \"mesh\"\nfile = \"water.obj\"\n";
        }
        out += fmt::format("size = [{0:.17g}, {0:.17g}]\ncenter = {1}\noutside = \"{2}\"\n", length(scene_.patch),
                           vector(place({0, 0, 0})), scene_.outside);
        switch (scene_.water) {
            case SceneModel::Water::Bump:
                return out + fmt::format("bump = {{ height = {:.17g}, radius = {:.17g}, resolution = 64 }}\n",
                                         length(scene_.height), length(0.2 * scene_.patch));
            case SceneModel::Water::Sea:
                return out + fmt::format("sea = {{ wind_speed = 2, fetch = 20, seed = {}, resolution = 32 }}\n",
                                         scene_.seed % 100);
            case SceneModel::Water::Waves: {
                std::string waves;
                for (const SceneModel::Wave& w : scene_.waves)
                    waves += fmt::format(
                        "{{ amplitude = {:.17g}, wavelength = {:.17g}, direction = {:.17g}, phase = {:.17g} }}, ",
                        length(w.amplitude), length(w.wavelength), w.direction, w.phase);
                return out + "waves = [" + waves + "]\n";
            }
            default:
                return out + "flat = true\n";
        }
    }

    // 12 x 12 squares whose heights are the first wave's, in lumps.
    void writeWater() const {
        constexpr int n = 12;
        std::vector<glm::dvec3> positions;
        std::vector<std::array<int, 3>> triangles;
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) {
                const glm::dvec2 p = scene_.patch * (glm::dvec2(i, j) / double(n) - 0.5);
                positions.push_back(place({p, scene_.height * std::sin(7 * p.x + 1) * std::cos(5 * p.y)}));
            }
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const int a = j * (n + 1) + i, d = a + n + 1;
                triangles.push_back({a, a + 1, d + 1}), triangles.push_back({a, d + 1, d});
            }
        writeObj(directory_ + "/water.obj", positions, triangles);
    }

    std::string object(const SceneModel::Thing& thing, std::size_t number) const {
        std::string out = fmt::format("[[object]]\nname = \"thing {}\"\nrole = \"{}\"\n", number, thing.role);
        switch (thing.shape) {
            case SceneModel::Shape::Plane:
                return out + fmt::format("plane = {{ point = {}, normal = {} }}\n", vector(place(thing.center)),
                                         vector(thing.size));
            case SceneModel::Shape::Box:
                return out + fmt::format("box = {{ min = {}, max = {} }}\n",
                                         vector(place(thing.center - 0.5 * thing.size)),
                                         vector(place(thing.center + 0.5 * thing.size)));
            case SceneModel::Shape::Ball:
                return out + fmt::format("sphere = {{ center = {}, radius = {:.17g} }}\n", vector(place(thing.center)),
                                         length(0.5 * thing.size.x));
            case SceneModel::Shape::Mesh:
                break;
        }
        truth::Triangles rock = truth::rock(thing.center, thing.size.x, 1, thing.seed);
        for (glm::dvec3& p : rock.positions) p = place(p);
        const std::string file = fmt::format("thing_{}.obj", number);
        writeObj(directory_ + "/" + file, rock.positions, rock.triangles);
        return out + fmt::format("file = \"{}\"\n", file);
    }

    const SceneModel& scene_;
    std::string directory_;
    glm::dvec3 offset_;
};

}  // namespace

std::string SceneModel::toml(const std::string& directory) const { return Writer(*this, directory).text(); }

}  // namespace photic::stability
