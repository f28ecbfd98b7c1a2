// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/receiver_picture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "bake/picture/view_scene.h"
#include "bake/picture/volume_lookup.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {

namespace {

Image blankImage(int width, int height, int channels) {
    Image image{width, height, channels, {}};
    image.pixels.assign(
        static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels), 0.0F);
    return image;
}

void put(Image& image, int x, int y, const glm::dvec3& value) {
    for (int c = 0; c < image.channels; ++c) image.at(x, y, c) = static_cast<float>(value[c]);
}

/// The image axes of pictures taken along `axis`: x right and y up, or z up where z is not the axis.
struct ImageAxes {
    int right, up;
};
ImageAxes imageAxes(int axis) {
    if (axis == 2) return {0, 1};
    return {axis == 0 ? 1 : 0, 2};
}

/// Calls body(x, y, first voxel of the line along `axis`) for each pixel of a picture across `axis`.
template <class Body>
Image acrossAxis(const LightVolume& volume, int axis, const Body& body) {
    if (axis < 0 || axis > 2) throw Error(ErrorCode::Usage, fmt::format("axis {} is not 0, 1 or 2", axis));
    const GridFrame& frame = volume.field.frame();
    const ImageAxes axes = imageAxes(axis);
    Image image = blankImage(frame.size()[axes.right], frame.size()[axes.up], volume.field.channels().irradiance);
    parallelFor(image.height, [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < image.width; ++x) {
            glm::ivec3 voxel = frame.min;
            voxel[axes.right] += x;
            voxel[axes.up] += image.height - 1 - y;
            put(image, x, y, body(voxel));
        }
    });
    return image;
}

const Object* findReceiver(const Scene& scene, const std::string& name) {
    const auto found = std::find_if(scene.objects.begin(), scene.objects.end(),
                                    [&](const Object& object) { return object.name == name && object.receives(); });
    return found == scene.objects.end() ? nullptr : &*found;
}

// A mesh seen along z: from the side that most of the light comes from.
Image meshPicture(const LightVolume& volume, const Scene& scene, const Object& object, int resolution) {
    Scene alone;
    alone.domain = scene.domain;
    alone.objects = {object};
    const MeshView view(alone);
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::dvec3& p : std::get<std::shared_ptr<const TriangleMesh>>(object.shape)->positions)
        low = glm::min(low, p), high = glm::max(high, p);
    const double top = high.z, bottom = low.z;
    low = glm::max(low, scene.domain.min), high = glm::min(high, scene.domain.max);
    const glm::dvec2 size(high - low);
    if (!(size.x > 0 && size.y > 0 && high.z >= low.z))
        throw Error(ErrorCode::Input,
                    fmt::format("receiver '{}' lies outside the domain; move it or enlarge [domain]", object.name),
                    object.where);
    double down = 0;
    for (const Light& light : scene.lights) down -= light.direction.z;
    const bool from_below = down < 0;
    const double texel = std::max(size.x, size.y) / resolution, margin = 1e-3 * (top - bottom) + texel;
    const VolumeLookup lookup(volume);
    Image image = blankImage(std::max(1, static_cast<int>(std::lround(size.x / texel))),
                             std::max(1, static_cast<int>(std::lround(size.y / texel))), lookup.coloured() ? 3 : 1);
    parallelFor(image.height, [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < image.width; ++x) {
            const glm::dvec3 eye(low.x + (x + 0.5) / image.width * size.x,
                                 low.y + (1 - (y + 0.5) / image.height) * size.y,
                                 from_below ? bottom - margin : top + margin);
            const glm::dvec3 direction(0, 0, from_below ? 1 : -1);
            const ViewHit hit = view.hit(eye, direction, std::numeric_limits<double>::infinity());
            if (hit) put(image, x, y, lookup.receiverIrradiance(eye + hit.distance * direction, hit.normal));
        }
    });
    return image;
}

}  // namespace

Image receiverPicture(const LightVolume& volume, const Scene& scene, const std::string& name, int resolution) {
    const Object* object = findReceiver(scene, name);
    if (object && !std::holds_alternative<Plane>(object->shape)) return meshPicture(volume, scene, *object, resolution);
    return receiverPicture(volume, receiverFrame(scene, name, resolution));
}

std::vector<std::string> receiverNames(const Scene& scene) {
    std::vector<std::string> names;
    for (const Object& object : scene.objects)
        if (object.receives()) names.push_back(object.name);
    return names;
}

Image receiverPicture(const LightVolume& volume, const PictureFrame& frame) {
    const VolumeLookup lookup(volume);
    Image image = blankImage(frame.width, frame.height, lookup.coloured() ? 3 : 1);
    parallelFor(frame.height, [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        const glm::dvec3 line = frame.origin + (1 - (y + 0.5) / frame.height) * frame.up;
        for (int x = 0; x < frame.width; ++x) {
            put(image, x, y, lookup.receiverIrradiance(line + (x + 0.5) / frame.width * frame.across, frame.normal));
        }
    });
    return image;
}

Image slicePicture(const LightVolume& volume, int axis, int layer) {
    const VolumeLookup lookup(volume);
    return acrossAxis(volume, axis, [&](glm::ivec3 voxel) {
        voxel[axis] = layer;
        return lookup.irradiance(voxel);
    });
}

Image xrayPicture(const LightVolume& volume, int axis) {
    const VolumeLookup lookup(volume);
    return acrossAxis(volume, axis, [&](glm::ivec3 voxel) {
        const int count = volume.field.frame().size()[axis];
        glm::dvec3 sum{0};
        for (int step = 0; step < count; ++step, ++voxel[axis]) sum += lookup.irradiance(voxel);
        return sum / static_cast<double>(count);
    });
}

std::vector<std::string> planarReceivers(const Scene& scene) {
    std::vector<std::string> names;
    for (const Object& object : scene.objects) {
        if (object.receives() && std::holds_alternative<Plane>(object.shape)) names.push_back(object.name);
    }
    return names;
}

PictureFrame receiverFrame(const Scene& scene, const std::string& name, int resolution) {
    const auto planes = planarReceivers(scene);
    if (std::find(planes.begin(), planes.end(), name) == planes.end()) {
        const auto names = receiverNames(scene);
        throw Error(
            ErrorCode::Input,
            names.empty()
                ? fmt::format("no receiver '{}': the scene has none; add an [[object]] with plane = {{...}} or file",
                              name)
                : fmt::format("no receiver '{}'; the scene has: {}", name, fmt::join(names, ", ")),
            scene.file);
    }
    const auto found = std::find_if(scene.objects.begin(), scene.objects.end(), [&](const Object& o) {
        return o.name == name && o.receives() && std::holds_alternative<Plane>(o.shape);
    });
    const Plane& plane = std::get<Plane>(found->shape);

    // Upright as seen from the lit side: up is north (+y) on floors and ceilings, the sky (+z) on walls.
    const glm::dvec3 n = glm::normalize(plane.normal);
    const glm::dvec3 sky = std::fabs(n.z) > 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
    const glm::dvec3 up = glm::normalize(sky - glm::dot(sky, n) * n), right = glm::cross(up, n);

    // The rectangle around the plane's cut through the domain: the points where it crosses the box's twelve edges.
    glm::dvec2 low(std::numeric_limits<double>::infinity()), high(-low);
    const glm::dvec3 box[2] = {scene.domain.min, scene.domain.max};
    const double slack = 1e-9 * glm::length(box[1] - box[0]);
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 4; ++side) {
            glm::dvec3 a{0}, b{0};
            a[axis] = box[0][axis], b[axis] = box[1][axis];
            a[(axis + 1) % 3] = b[(axis + 1) % 3] = box[side & 1][(axis + 1) % 3];
            a[(axis + 2) % 3] = b[(axis + 2) % 3] = box[side >> 1][(axis + 2) % 3];
            const double da = glm::dot(a - plane.point, n), db = glm::dot(b - plane.point, n);
            for (const double t : {0.0, 1.0, da / (da - db)}) {
                if (!(t >= 0 && t <= 1) || std::fabs(da + t * (db - da)) > slack) continue;
                const glm::dvec3 p = a + t * (b - a) - plane.point;
                low = glm::min(low, glm::dvec2(glm::dot(p, right), glm::dot(p, up)));
                high = glm::max(high, glm::dvec2(glm::dot(p, right), glm::dot(p, up)));
            }
        }
    }
    const glm::dvec2 size = high - low;
    if (!(size.x > slack && size.y > slack)) {
        throw Error(ErrorCode::Input,
                    fmt::format("receiver '{}' lies outside the domain; move it or enlarge [domain]", name),
                    found->where);
    }

    PictureFrame frame;
    frame.origin = plane.point + low.x * right + low.y * up;
    frame.across = size.x * right;
    frame.up = size.y * up;
    frame.normal = n;
    const double texel = std::max(size.x, size.y) / resolution;
    frame.width = std::max(1, static_cast<int>(std::lround(size.x / texel)));
    frame.height = std::max(1, static_cast<int>(std::lround(size.y / texel)));
    return frame;
}

}  // namespace photic
