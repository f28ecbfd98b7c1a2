// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/ray_casting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "bake/libraries/embree.h"
#include "bake/report/error.h"

namespace photic {
namespace {

// Of the meshes' size: a specular face this close before another hit lies on it.
constexpr double kSameFace = 2e-6;
// Of the meshes' half diagonal: some thirty units in the last place of single precision at the far corner.
constexpr float kSelfHitOffset = 4e-6f;
constexpr double kOnPlane = 1e-12;  // of the distance to the world's origin

struct DeviceDeleter {
    void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
};
struct SceneDeleter {
    void operator()(RTCScene s) const { rtcReleaseScene(s); }
};
template <class Handle, class Deleter>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Deleter>;

void checkDevice(RTCDevice device, std::size_t triangles) {
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_NONE) return;
    throw Error(
        ErrorCode::Failed,
        fmt::format("Embree failed with error {} on {} triangles{}", static_cast<int>(error), triangles,
                    error == RTC_ERROR_OUT_OF_MEMORY ? ": out of memory; simplify the meshes that block light" : ""));
}

struct CastMesh {
    Target target;
    const TriangleMesh* mesh;
};

struct CastPlane {
    Target target;
    Plane plane;
};

struct CastSphere {
    Target target;
    Sphere sphere;
};

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

struct RayCaster::Impl {
    std::vector<CastPlane> planes;
    std::vector<CastSphere> spheres;
    std::vector<CastMesh> meshes;
    std::vector<std::shared_ptr<const TriangleMesh>> keep_alive;
    glm::dvec3 centre{0};
    double radius = 0;  // half diagonal of the meshes' bounds [m]: Embree's unit of length
    Owned<RTCDevice, DeviceDeleter> device;
    Owned<RTCScene, SceneDeleter> scene;  // after the device, so that it is released first

    void add(Target target, const std::shared_ptr<const TriangleMesh>& mesh, const std::string& name,
             const std::string& where) {
        if (!mesh || mesh->triangles.empty()) return;
        // Doubles still tell a metre there. Rays from far beyond are not finite in Embree's floats, and it aborts.
        constexpr double kFarthest = 1e15;
        for (const glm::dvec3& p : mesh->positions)
            if (const double reach = glm::length(p); reach > kFarthest)
                throw Error(
                    ErrorCode::Input,
                    fmt::format("'{}' reaches {:.3g} m from the origin, more than {:.0e}; move the scene closer to it",
                                name, reach, kFarthest),
                    where);
        for (const glm::dvec3& p : mesh->positions)
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                throw Error(ErrorCode::Input,
                            fmt::format("mesh '{}' has a position ({}, {}, {}) that is not finite; repair the mesh",
                                        name, p.x, p.y, p.z),
                            where);
        for (const auto& t : mesh->triangles)
            if (std::max({t[0], t[1], t[2]}) >= mesh->positions.size())
                throw Error(ErrorCode::Input,
                            fmt::format("mesh '{}' has a triangle with vertex {}, but only {} positions", name,
                                        std::max({t[0], t[1], t[2]}), mesh->positions.size()),
                            where);
        meshes.push_back({target, mesh.get()});
        keep_alive.push_back(mesh);
    }

    void build() {
        if (meshes.empty()) return;
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
        std::size_t triangles = 0;
        for (const auto& m : meshes) {
            triangles += m.mesh->triangles.size();
            for (const glm::dvec3& p : m.mesh->positions) low = glm::min(low, p), high = glm::max(high, p);
        }
        centre = 0.5 * low + 0.5 * high;
        radius = glm::length(0.5 * high - 0.5 * low);
        if (!std::isfinite(radius))
            throw Error(ErrorCode::Input,
                        fmt::format("the meshes span {} m; scale them to less than 1e150 m", (high - low).x));
        if (radius == 0) {  // all in one point: nothing can be hit
            meshes.clear();
            return;
        }

        device.reset(rtcNewDevice(nullptr));
        if (!device)
            throw Error(ErrorCode::Failed,
                        fmt::format("Embree did not start (error {})", static_cast<int>(rtcGetDeviceError(nullptr))));
        scene.reset(rtcNewScene(device.get()));
        rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | embree::kVisitable));
        for (std::size_t id = 0; id < meshes.size(); ++id)
            attach(*meshes[id].mesh, static_cast<unsigned>(id), triangles);
        rtcCommitScene(scene.get());
        checkDevice(device.get(), triangles);
    }

    void attach(const TriangleMesh& mesh, unsigned id, std::size_t triangles) const {
        const RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions.size()));
        auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
        if (!vertices || !indices) {
            rtcReleaseGeometry(geometry);
            checkDevice(device.get(), triangles);
            throw Error(ErrorCode::Failed, fmt::format("Embree has no memory for {} triangles", triangles));
        }
        for (const glm::dvec3& p : mesh.positions) {
            const glm::dvec3 q = (p - centre) / radius;
            for (int a = 0; a < 3; ++a) *vertices++ = static_cast<float>(q[a]);
        }
        for (const auto& t : mesh.triangles)
            for (const std::uint32_t i : t) *indices++ = i;
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene.get(), geometry, id);
        rtcReleaseGeometry(geometry);
    }

    void hitPlanes(const glm::dvec3& origin, const glm::dvec3& direction, RayHit& best) const {
        for (const CastPlane& p : planes) {
            const double along = glm::dot(direction, p.plane.normal);
            if (along == 0) continue;
            const double t = glm::dot(p.plane.point - origin, p.plane.normal) / along;
            const double scale = glm::length(origin) + glm::length(p.plane.point);
            if (t > kOnPlane * scale && t < best.distance)
                best = {t, p.target, 0, glm::dvec2(0), along < 0 ? p.plane.normal : -p.plane.normal};
        }
    }

    void hitSpheres(const glm::dvec3& origin, const glm::dvec3& direction, RayHit& best) const {
        for (const CastSphere& s : spheres) {
            const double r = s.sphere.radius, self = roundingOnSphere(s.sphere);
            const glm::dvec3 to = s.sphere.center - origin;
            const double along = glm::dot(to, direction);
            const glm::dvec3 miss = to - along * direction;
            const double half2 = r * r - glm::dot(miss, miss);
            if (half2 <= 0) continue;
            const double half = std::sqrt(half2);
            // A ray that starts on the sphere meets it once more, on the far side, or not at all.
            const double t = along - half > self ? along - half : along + half;
            if (!(t > self) || t >= best.distance) continue;
            const glm::dvec3 outward = (origin + t * direction - s.sphere.center) / r;
            best = {t, s.target, 0, glm::dvec2(0), glm::dot(outward, direction) < 0 ? outward : -outward};
        }
    }

    // A hit of Embree's on the face that it names, in double.
    struct Exact {
        double distance = 0;  // [m]
        bool known = false;   // else it is Embree's own
        glm::dvec3 normal{0};
    };
    Exact exactly(const RTCRayHit& query, const glm::dvec3& origin, const glm::dvec3& direction, double start) const {
        const TriangleMesh& mesh = *meshes[query.hit.geomID].mesh;
        const auto& corner = mesh.triangles[query.hit.primID];
        const glm::dvec3 &a = mesh.positions[corner[0]], &b = mesh.positions[corner[1]], &c = mesh.positions[corner[2]];
        const glm::dvec3 normal = glm::cross((b - a) / radius, (c - a) / radius);
        const double area = glm::length(normal), along = glm::dot(direction, normal);
        Exact exact{(start + static_cast<double>(query.ray.tfar)) * radius, false,
                    area > 0 ? normal / area : -direction};
        if (!(area > 0 && std::fabs(along) > 1e-4 * area)) return exact;
        const double distance = glm::dot(a - origin, normal) / along;
        // A sliver's plane may be off; Embree's own distance is never wrong by more than this.
        exact.known = std::fabs(distance - exact.distance) <= 1e-5 * radius / std::min(1.0, std::fabs(along) / area);
        if (exact.known) exact.distance = distance;
        return exact;
    }

    // In units of the meshes' half diagonal, about their centre.
    static RTCRayHit queryFrom(const glm::dvec3& from, const glm::dvec3& direction) {
        RTCRayHit query{};
        query.ray.org_x = static_cast<float>(from.x), query.ray.org_y = static_cast<float>(from.y),
        query.ray.org_z = static_cast<float>(from.z);
        query.ray.dir_x = static_cast<float>(direction.x), query.ray.dir_y = static_cast<float>(direction.y),
        query.ray.dir_z = static_cast<float>(direction.z);
        query.ray.mask = ~0u;
        query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        return query;
    }

    // For each mesh, whether a ray meets an odd number of an object's faces.
    std::vector<bool> oddFaces(const glm::dvec3& from, const glm::dvec3& direction) const {
        struct Crossing {
            unsigned mesh;
            float distance;
            bool leaving;
        };
        std::vector<Crossing> crossings;
        std::vector<bool> odd(meshes.size(), false);
        const auto visit = [&](unsigned mesh, float distance, float cosine) {
            const bool leaving = cosine > 0;
            // On an edge the ray meets both of its triangles.
            const bool again = std::any_of(crossings.begin(), crossings.end(), [&](const Crossing& c) {
                return c.mesh == mesh && c.leaving == leaving &&
                       std::fabs(c.distance - distance) < static_cast<float>(kSameFace);
            });
            if (again || meshes[mesh].target.kind != Target::Kind::Object) return;
            crossings.push_back({mesh, distance, leaving});
            odd[mesh] = !odd[mesh];
        };
        constexpr float kLongest = 2.001f;  // through all of them
        RTCRayHit query = queryFrom(from, direction);
        query.ray.tnear = 0, query.ray.tfar = kLongest;
        embree::visitHits(scene.get(), query, visit);
        return odd;
    }

    bool insideMesh(const glm::dvec3& point, const glm::dvec3& direction) const {
        const glm::dvec3 from = (point - centre) / radius;
        if (glm::dot(from, from) > 1.0) return false;
        const std::vector<bool> ahead = oddFaces(from, direction), behind = oddFaces(from, -direction);
        for (std::size_t m = 0; m < meshes.size(); ++m)
            if (ahead[m] && behind[m]) return true;
        return false;
    }

    void hitMeshes(const glm::dvec3& origin, const glm::dvec3& direction, RayHit& best) const {
        // Start at the bounding sphere: single precision then never sees a far origin.
        const glm::dvec3 o = (origin - centre) / radius;
        const double towards = -glm::dot(o, direction), miss2 = glm::dot(o, o) - towards * towards;
        if (miss2 > 1.0 + 1e-6) return;
        const double half_chord = std::sqrt(std::max(0.0, 1.0 - miss2)) + 1e-3;
        const double exit = towards + half_chord, start = std::max(0.0, towards - half_chord);
        if (exit <= 0 || start * radius >= best.distance) return;
        RTCRayHit query = queryFrom(o + start * direction, direction);
        query.ray.tnear = start > 0 ? 0.0f : kSelfHitOffset;
        // A little further than asked: the exact distance is compared below.
        const float farthest =
            static_cast<float>(std::min(exit - start, best.distance / radius - start)) * (1.0f + 1e-5f) +
            kSelfHitOffset;
        Exact exact;
        // A ray that grazes the face that it starts on meets it again, by single precision, farther off than any
        // offset: in double it does not.
        constexpr int kMostOnOwnFace = 4;
        for (int tries = 0; tries < kMostOnOwnFace; ++tries) {
            query.ray.tfar = farthest;
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            embree::intersect(scene.get(), query);
            if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
            exact = exactly(query, origin, direction, start);
            if (start > 0 || !exact.known || exact.distance > double(kSelfHitOffset) * radius) break;
            query.ray.tnear = std::nextafter(query.ray.tfar, std::numeric_limits<float>::infinity());
        }
        const CastMesh& cast = meshes[query.hit.geomID];
        // What stands on a plane ends there: of the two faces that lie in one, rounding must not choose.
        const double tie = best && cast.target.kind == Target::Kind::Surface ? kSameFace * radius : 0;
        if (exact.distance < best.distance - tie)
            best = {std::max(exact.distance, 0.0), cast.target, query.hit.primID, glm::dvec2(query.hit.u, query.hit.v),
                    glm::dot(exact.normal, direction) < 0 ? exact.normal : -exact.normal};
    }
};

RayCaster::RayCaster(const Scene& scene) : impl_(std::make_unique<Impl>()) {
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
        const Surface& surface = scene.surfaces[i];
        const Target target{Target::Kind::Surface, static_cast<int>(i)};
        if (surface.sphere)
            impl_->spheres.push_back({target, *surface.sphere});
        else
            impl_->add(target, surface.mesh, surface.name, surface.where);
    }
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        const Target target{Target::Kind::Object, static_cast<int>(i)};
        if (!object.blocks()) continue;
        if (const auto* plane = std::get_if<Plane>(&object.shape))
            impl_->planes.push_back({target, *plane});
        else
            impl_->add(target, std::get<1>(object.shape), object.name, object.where);
    }
    impl_->build();
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;

bool RayCaster::empty() const { return impl_->planes.empty() && impl_->spheres.empty() && impl_->meshes.empty(); }
bool RayCaster::planesOnly() const { return impl_->meshes.empty() && impl_->spheres.empty(); }
bool RayCaster::hasPlanes() const { return !impl_->planes.empty(); }
double RayCaster::reachFrom(const glm::dvec3& point) const {
    double reach = impl_->meshes.empty() ? 0 : glm::length(point - impl_->centre) + impl_->radius;
    for (const CastSphere& s : impl_->spheres)
        reach = std::max(reach, glm::length(point - s.sphere.center) + s.sphere.radius);
    return reach;
}

double roundingOnSphere(const Sphere& sphere) {
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    const double place = sphere.radius + glm::length(sphere.center);
    return 8 * std::sqrt(kEpsilon * place * sphere.radius);
}

bool RayCaster::insideBody(const glm::dvec3& point, const glm::dvec3& direction) const {
    return finite(point) && finite(direction) && !impl_->meshes.empty() && impl_->insideMesh(point, direction);
}

bool RayCaster::planeStandsBefore(const glm::dvec3& point, const glm::dvec3& travel) const {
    constexpr double kAlong = 1e-12;
    return std::any_of(impl_->planes.begin(), impl_->planes.end(), [&](const CastPlane& p) {
        const double along = -glm::dot(travel, p.plane.normal);
        const double t = glm::dot(p.plane.point - point, p.plane.normal) / along;
        return std::fabs(along) > kAlong && t > kOnPlane * (glm::length(point) + glm::length(p.plane.point));
    });
}

bool RayCaster::planeParts(const glm::dvec3& travel, double radius) const {
    return std::any_of(impl_->planes.begin(), impl_->planes.end(), [&](const CastPlane& p) {
        return std::fabs(glm::dot(travel, p.plane.normal)) < std::sin(radius);
    });
}

RayHit RayCaster::firstHit(const glm::dvec3& origin, const glm::dvec3& direction, double max_distance,
                           EndlessPlanes planes) const {
    RayHit best;
    // Embree aborts on rays that are not finite.
    if (!finite(origin) || !finite(direction)) return best;
    best.distance = max_distance;
    if (planes == EndlessPlanes::Met) impl_->hitPlanes(origin, direction, best);
    impl_->hitSpheres(origin, direction, best);
    if (!impl_->meshes.empty()) impl_->hitMeshes(origin, direction, best);
    if (!best) best.distance = std::numeric_limits<double>::infinity();
    return best;
}

}  // namespace photic
