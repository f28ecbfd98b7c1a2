// SPDX-License-Identifier: Apache-2.0
// Eye rays through objects whose index varies. Behind photic_bent.glsl and the functions
//     vec3 photicEnvironment(vec3 direction)
//     bool photicNearby(vec3 from, vec3 direction, float limit, out vec3 radiance)    // what opaque thing is met, if any
// and, with PHOTIC_LIT, behind photic_volume.glsl and photic_phase.glsl.
//
// A ray goes as a ball under gravity, dx/ds = p, dp/ds = grad(n^2 / 2), |p| = n (Ihrke et al. 2007, eqs. 8 to 10, with s
// instead of length): half a step straight on, one look at the gradient, half a step with the new momentum. With
// PHOTIC_EULER by their eqs. 11 and 12 instead.

#define PHOTIC_BENT_STACK 4
#define PHOTIC_BENT_STEP 0
#define PHOTIC_BENT_ENTER 1  // through a sharp side
#define PHOTIC_BENT_START 2  // the eye is in an object
#define PHOTIC_BENT_SEEK 3   // along the ray, for the place where a face is
#define PHOTIC_BENT_PEAK 4   // there: which way it looks
#define PHOTIC_BENT_PROBE 5  // behind it, for its index there
#define PHOTIC_BENT_LAND 6   // on it
#define PHOTIC_BENT_MEET 7   // behind a sharp face of a shape, for the index there
// Of shapes, without a look-up: the eye's ray, before it is known what it is in; at a face; at one behind which n is known.
#define PHOTIC_BENT_BORN 8
#define PHOTIC_BENT_MET 9
#define PHOTIC_BENT_CROSS 10

/// A ray, as it is followed. Where nothing bends it, it goes straight from `start`: places are start + count * step *
/// momentum, never summed up, so that passing over many steps at once changes no bit.
struct PhoticBentRay {
    vec3 start;
    vec3 momentum;  // as long as n
    float step, count;
    vec3 force;     // at the last look [1/m]
    int object;     // -1: in air; -2: just out of a box
    int look;       // what its next look-up is for: PHOTIC_BENT_STEP ...
    vec3 weight;    // what of the radiance from further on arrives, times (n_there / n_eye)^2
};
/// A face that is being looked for. In samples a face is some nodes wide; light is refracted where it lies, in the middle
/// of its jump, as by the face that was sampled: what a ray does within its width would be off by the width over the
/// face's radius.
struct PhoticBentFace {
    vec3 way;         // a node along the ray [m]
    float along;      // nodes gone
    float last, before;  // strength of the gradient at the last two places
    float peak;       // nodes to where it is strongest, then to the middle of the jump
    vec3 normal;      // a node across the face, to its far side [m]
    float excess, slope, way_slope;  // (n^2 - 1) / 2 at the peak, and what it changes a node, across and along the ray
    float probe;      // nodes behind it
    bool settled;     // the index changes no more there
    float far;        // excess behind it
    vec3 near, beyond;  // gradients before and behind [1/m]
    vec3 passed;      // sum of the gradients at the places gone by [1/m]
    bool met;         // there was a peak, though perhaps it was only passed by
};

/// Share of the power that a face reflects, averaged over both polarisations, from the momentum before and after along
/// its normal and n^2 of both sides.
float photicFresnel(float a, float b, float square_a, float square_b) {
    float s = (b - a) / (b + a), q = square_b * a / (square_a * b), p = (q - 1.0) / (q + 1.0);
    return min(1.0, 0.5 * (s * s + p * p));
}

/// What of the radiance at `n` arrives, given what of basic radiance (over n^2) does.
float photicBasic(float square) { return photic_bent_march.w != 0.0 ? 1.0 : 1.0 / square; }

/// State of a pixel's tree of rays.
vec3 photic_bent_sum;
PhoticBentRay photic_bent_ray;
PhoticBentFace photic_bent_face;
vec3 photic_bent_places[PHOTIC_BENT_STACK], photic_bent_ways[PHOTIC_BENT_STACK], photic_bent_weights[PHOTIC_BENT_STACK];
int photic_bent_pending;
bool photic_bent_touched;
#ifdef PHOTIC_BENT_SHAPES
int photic_bent_inside, photic_bent_body;  // bits of the objects whose shapes the ray is in; that which is there, -1: none
int photic_bent_insides[PHOTIC_BENT_STACK];
float photic_bent_back;  // how far behind `start` the ray's line was not yet searched for faces
#endif
// A stretch with one medium and no bend: steps, and what it does.
float photic_bent_stretch;
vec3 photic_bent_extinction, photic_bent_emission;

vec3 photicBentPlace() {
    return photic_bent_ray.start + (photic_bent_ray.count * photic_bent_ray.step) * photic_bent_ray.momentum;
}

/// Light of a length of medium with one extinction and emission, and what it takes.
void photicBentPass(vec3 extinction, vec3 emission, float length_m, float square) {
    if (extinction == vec3(0.0) && emission == vec3(0.0)) return;
    vec3 depth = extinction * length_m, left = exp(-depth);
    vec3 mean = mix((1.0 - left) / max(depth, vec3(1e-6)), 1.0 - 0.5 * depth, lessThan(depth, vec3(0.001)));
    if (photic_bent_origin.w == 0.0)
        photic_bent_sum += photic_bent_ray.weight * emission * mean * (length_m * photicBasic(square));
    photic_bent_ray.weight *= left;
    photic_bent_touched = true;
}

/// Ends the stretch.
void photicBentFlush() {
    if (photic_bent_stretch > 0.0) {
        float square = dot(photic_bent_ray.momentum, photic_bent_ray.momentum);
        photicBentPass(photic_bent_extinction, photic_bent_emission,
                       photic_bent_stretch * photic_bent_ray.step * sqrt(square), square);
    }
    photic_bent_stretch = 0.0;
}

/// A branch is kept for later, or, where there is no room or it is faint, sees the environment straight away.
void photicBentPush(vec3 place, vec3 momentum, vec3 weight) {
    float strongest = max(weight.x, max(weight.y, weight.z));
    if (strongest <= 0.0) return;
    photic_bent_touched = true;
    if (photic_bent_pending < min(PHOTIC_BENT_STACK, photic_bent_counts.z) && strongest >= photic_bent_march.z) {
        photic_bent_places[photic_bent_pending] = place;
        photic_bent_ways[photic_bent_pending] = momentum;
        photic_bent_weights[photic_bent_pending] = weight;
#ifdef PHOTIC_BENT_SHAPES
        photic_bent_insides[photic_bent_pending] = photic_bent_inside;
#endif
        ++photic_bent_pending;
    } else {
        photic_bent_sum += weight * photicEnvironment(normalize(momentum));
    }
}

#ifdef PHOTIC_LIT
/// Light of the volume that a step scatters towards the eye.
void photicBentScatter(PhoticBentMedium m, vec3 place, float length_m, float square) {
    if (m.scattering == vec3(0.0)) return;
    PhoticLight light = photicSample(place + photic_bent_origin.xyz);
    if (!(light.mean > 0.0)) return;
    float size = length(light.flux);
    float cosine = size > 0.0 ? -dot(light.flux, photic_bent_ray.momentum) / (size * sqrt(square)) : 0.0;
    float phase = photicPhase(cosine, m.anisotropy * min(1.0, size / light.mean));
    vec3 half_way = exp(-0.5 * length_m * (m.absorption + m.scattering));
    photic_bent_sum += photic_bent_ray.weight * half_way * m.scattering * light.irradiance *
                       (phase * length_m * photicBasic(square));
    photic_bent_touched = true;
}
#endif

void photicBentBegin(vec3 place, vec3 momentum, vec3 weight, int object) {
    photic_bent_ray = PhoticBentRay(place, momentum, 0.0, 0.0, vec3(0.0), object, PHOTIC_BENT_STEP, weight);
    photic_bent_stretch = 0.0;
#ifdef PHOTIC_BENT_SHAPES
    photic_bent_back = 0.0;
#endif
}

#ifdef PHOTIC_BENT_SHAPES
#include "photic_bent_shape.glsl"
#endif
#include "photic_bent_face.glsl"
#ifdef PHOTIC_BENT_SHAPES
#include "photic_bent_shape_cross.glsl"
#else
#define photicBentSamples(place) photicBentFind(place)
#endif

/// At a sharp side of an object's box: refracts the ray, or reflects all of it. @param into  of the object
/// @param square  n^2 on the side that it goes to
void photicBentCrossSide(int object, vec3 place, bool into, float square) {
    vec3 node = photicBentNode(object, place);
    vec3 low = node - photic_bent_objects[object].box_low.xyz, high = photic_bent_objects[object].box_high.xyz - node;
    vec3 nearest = min(abs(low), abs(high));
    vec3 row = nearest.x <= nearest.y && nearest.x <= nearest.z   ? photic_bent_objects[object].row_x.xyz
               : nearest.y <= nearest.z ? photic_bent_objects[object].row_y.xyz
                                        : photic_bent_objects[object].row_z.xyz;
    vec3 normal = normalize(row), p = photic_bent_ray.momentum;
    float a = dot(p, normal);
    if (a < 0.0) normal = -normal, a = -a;
    vec3 along = p - a * normal, mirrored = along - a * normal;
    float b2 = square - dot(along, along);
    // A hair beyond the side, where the ray is on the one it goes on in.
    vec3 hair = normal * (1e-3 * photic_bent_objects[object].scattering.w);
    photic_bent_touched = true;
    photic_bent_ray.weight *=
        1.0 - photicBentReflect(object, node, place - hair, -normal, p, square, photic_bent_ray.weight);
    if (b2 <= 0.0) {
        photicBentBegin(place - hair, mirrored, photic_bent_ray.weight, into ? -1 : object);
        return;
    }
    float share = photicFresnel(a, sqrt(b2), dot(p, p), square);
    photicBentPush(place - hair, mirrored, photic_bent_ray.weight * share);
    photicBentBegin(place + hair, along + sqrt(b2) * normal, photic_bent_ray.weight * (1.0 - share), into ? object : -1);
}

/// Steps to take at once: those that are alike for certain.
float photicBentJump(int object, vec3 node, vec3 rate) {
    int reach = photicBentReach(object, node);
    vec3 block = floor(node * 0.5);
    vec3 low = max((block - float(reach - 1)) * 2.0, photic_bent_objects[object].box_low.xyz);
    vec3 high = min((block + float(reach)) * 2.0, photic_bent_objects[object].box_high.xyz);
    vec3 room = mix(node - low, high - node, greaterThan(rate, vec3(0.0)));
    vec3 steps = room / max(abs(rate), vec3(1e-12));
    // One less, so that the ray doesn't pass a sharp side either.
    return max(1.0, floor(min(steps.x, min(steps.y, steps.z))) - 1.0);
}

#ifdef PHOTIC_EULER
/// The paper's step, eqs. 11 and 12: v is our momentum, and the length of a step is the same everywhere.
void photicBentEuler(PhoticRefraction here) {
    int object = photic_bent_ray.object;
    float n = sqrt(1.0 + 2.0 * here.excess), ds = photic_bent_march.x * photic_bent_objects[object].scattering.w;
    photic_bent_ray.start += (ds / n) * photic_bent_ray.momentum;
    photic_bent_ray.momentum += (ds / n) * here.gradient;
    PhoticBentMedium medium = photicBentMedium(object, photicBentNode(object, photic_bent_ray.start));
    photicBentPass(medium.absorption + medium.scattering, medium.emission, ds, n * n);
    photic_bent_touched = photic_bent_touched || here.gradient != vec3(0.0);
    if (!photicBentHolds(object, photicBentNode(object, photic_bent_ray.start))) photic_bent_ray.object = -2;
}
#endif

/// What a step does that bends, scatters, or ends at a sharp side.
void photicBentKick(vec3 middle, vec3 force, PhoticBentMedium medium, bool bends, bool leaves) {
    photicBentFlush();
    float step = photic_bent_ray.step, square = dot(photic_bent_ray.momentum, photic_bent_ray.momentum);
    vec3 momentum = photic_bent_ray.momentum + step * force;
    float length_m = 0.5 * step * (sqrt(square) + length(momentum));
#ifdef PHOTIC_LIT
    photicBentScatter(medium, middle, length_m, square);
#endif
    photicBentPass(medium.absorption + medium.scattering, medium.emission, length_m, square);
    photic_bent_touched = photic_bent_touched || bends;
    if (bends || leaves) {
        photic_bent_ray.start = middle + (0.5 * step) * momentum;
        photic_bent_ray.momentum = momentum;
        photic_bent_ray.count = 0.0;
#ifdef PHOTIC_BENT_SHAPES
        photic_bent_back = 0.5 * step;
#endif
    } else {
        photic_bent_ray.count += 1.0;
    }
    photic_bent_ray.force = force;
}

/// The ray goes on from where it is, with another momentum or step.
void photicBentAnew() {
    photicBentFlush();
#ifdef PHOTIC_BENT_SHAPES
    photicBentMoveHit(photic_bent_ray.count * photic_bent_ray.step);
#endif
    photic_bent_ray.start = photicBentPlace();
    photic_bent_ray.count = 0.0;
}

/// One step that goes straight on, or `jump` that are alike.
void photicBentDrift(PhoticBentMedium medium, float jump, float longest) {
    vec3 extinction = medium.absorption + medium.scattering;
    if (extinction != photic_bent_extinction || medium.emission != photic_bent_emission) photicBentFlush();
    photic_bent_extinction = extinction;
    photic_bent_emission = medium.emission;
    photic_bent_stretch += jump;
    photic_bent_ray.count += jump;
    photic_bent_ray.force = vec3(0.0);
    if (photic_bent_ray.step < longest) {
        photicBentAnew();
    }
}

/// One look at the index, in the ray's object, and what follows: a step, or several that are alike.
void photicBentLook(int channel) {
    int object = photic_bent_ray.object;
    float n = length(photic_bent_ray.momentum), longest = 0.0, room = 1e30;
    vec3 place = photic_bent_ray.start, node = vec3(0.0);
    bool even = false, leaves = false, meets = false;
#ifndef PHOTIC_EULER
    if (photic_bent_ray.look == PHOTIC_BENT_STEP) {
        longest = photic_bent_march.x / length(photicBentNodeVector(object, photic_bent_ray.momentum));
        if (photic_bent_ray.count == 0.0)
            photic_bent_ray.step = min(longest, photic_bent_march.y * n / max(length(photic_bent_ray.force), 1e-12));
        if (photic_bent_objects[object].box_low.w != 0.0) {
            room = photicBentBox(object, photicBentPlace(), photic_bent_ray.momentum).y;
            leaves = room <= photic_bent_ray.step;
            if (leaves) {
                photicBentAnew();
                photic_bent_ray.step = max(room, 0.0);
            }
        }
#ifdef PHOTIC_BENT_SHAPES
        meets = photic_bent_hit.object >= 0 && photicBentRoom() <= photic_bent_ray.step;
        if (meets) {
            photicBentAnew();
            photic_bent_ray.step = max(photic_bent_hit.along, 0.0);
            leaves = false;
        }
#endif
        place = photic_bent_ray.start +
                ((photic_bent_ray.count + 0.5) * photic_bent_ray.step) * photic_bent_ray.momentum;
        node = photicBentNode(object, place);
        even = photic_bent_counts.w != 0 && !meets && photic_bent_objects[object].block.w == 0 && photicBentReach(object, node) > 0;
    }
#endif
#ifndef PHOTIC_EULER
    if (photic_bent_ray.look >= PHOTIC_BENT_SEEK) {
        float along = photic_bent_ray.look == PHOTIC_BENT_SEEK ? photic_bent_face.along : photic_bent_face.peak;
        place = photic_bent_ray.start + along * photic_bent_face.way;
        if (photic_bent_ray.look == PHOTIC_BENT_PROBE) place += photic_bent_face.probe * photic_bent_face.normal;
        node = photicBentNode(object, place);
    }
#endif
    PhoticRefraction here = PhoticRefraction(0.0, vec3(0.0));
    if (!even) here = photicBentAt(object, place, channel);
#ifdef PHOTIC_BENT_COUNTS
    if (!even) photicBentCount(photic_bent_ray.look - PHOTIC_BENT_SEEK, here);
#endif
    float square = 1.0 + 2.0 * here.excess;
#ifdef PHOTIC_BENT_SHAPES
    if (photic_bent_ray.look == PHOTIC_BENT_MEET) {
        photic_bent_crossing.square = square;
        photic_bent_ray.look = PHOTIC_BENT_CROSS;
        return;
    }
#endif
    if (photic_bent_ray.look == PHOTIC_BENT_ENTER) {
        photicBentCrossSide(object, place, true, square);
        return;
    }
    if (photic_bent_ray.look == PHOTIC_BENT_START) {
        photic_bent_ray.look = PHOTIC_BENT_STEP;
        photic_bent_ray.momentum *= sqrt(square);
        if (photic_bent_march.w == 0.0) photic_bent_ray.weight *= square;
        return;
    }
#ifdef PHOTIC_EULER
    photicBentEuler(here);
#else
    if (photic_bent_ray.look >= PHOTIC_BENT_SEEK) {
        photicBentSeek(object, place, node, here);
        return;
    }
    vec3 force = here.gradient;
    float strength = length(force), step = photic_bent_ray.step;
    bool bends = strength > 0.0, fresh = photic_bent_ray.count == 0.0 && photic_bent_ray.force == vec3(0.0);
    if (bends && !meets && photicBentFace(object, node)) {
        photicBentAnew();
        photicBentSeekFrom(force, fresh);
        return;
    }
    // Too long for what was met: again, shorter.
    if (strength * step > 1.5 * photic_bent_march.y * n && !leaves && !meets && step > 0.02 * longest) {
        photicBentAnew();
        photic_bent_ray.force = force;
        return;
    }
    PhoticBentMedium medium = photicBentMedium(object, node);
#ifdef PHOTIC_BENT_SHAPES
    medium.absorption += photic_bent_base_absorption;
    vec3 meeting = photic_bent_ray.start + photic_bent_hit.along * photic_bent_ray.momentum;
#endif
    bool scatters = false;
#ifdef PHOTIC_LIT
    scatters = medium.scattering != vec3(0.0);
#endif
    if (bends || scatters || leaves || meets) {
        photicBentKick(place, force, medium, bends, leaves || meets);
    } else {
        float jump = 1.0;
        if (even && step == longest)
            jump = photicBentJump(object, node, photicBentNodeVector(object, photic_bent_ray.momentum) * step);
#ifdef PHOTIC_BENT_SHAPES
        jump = min(jump, max(floor(photicBentRoom() / step), 1.0));
#endif
        photicBentDrift(medium, jump, longest);
    }
#ifdef PHOTIC_BENT_SHAPES
    if (meets) {
        photicBentBegin(meeting, photic_bent_ray.momentum, photic_bent_ray.weight, object);
        photic_bent_ray.look = PHOTIC_BENT_MET;
        return;
    }
    if (photicBentShaped(object)) return;  // it ends at its faces
#endif
    if (leaves) {
        photicBentCrossSide(object, photicBentPlace(), false, 1.0 + 2.0 * photic_bent_base);
    } else if (!photicBentHolds(object, photicBentNode(object, photicBentPlace()))) {
        photicBentFlush();
        photic_bent_ray.object = -2;  // whether in another is looked up next
    }
#endif
}

/// In air, or in a shape of one index: on to the next object, or to what is behind all. @return whether the ray has ended
bool photicBentFree() {
    vec3 place = photicBentPlace();
    if (photic_bent_ray.object == -2) {
        photic_bent_ray.object = photicBentFind(place);
        if (photic_bent_ray.object >= 0) {
            photicBentBegin(place, photic_bent_ray.momentum, photic_bent_ray.weight, photic_bent_ray.object);
            return false;
        }
#ifdef PHOTIC_BENT_SHAPES
        photicBentBegin(place, photic_bent_ray.momentum, photic_bent_ray.weight, -1);
        return false;
#endif
    }
    vec3 direction = normalize(photic_bent_ray.momentum);
    int next = -1;
    float nearest = 1e30;
    for (int i = 0; i < photic_bent_counts.x; ++i) {
        if (photicBentShaped(i)) continue;
        vec2 box = photicBentBox(i, place, direction);
        if (box.y > max(box.x, 1e-6) && max(box.x, 0.0) < nearest && box.x > 0.0) nearest = box.x, next = i;
    }
#ifdef PHOTIC_BENT_SHAPES
    float n = sqrt(1.0 + 2.0 * photic_bent_base), face = 1e30;
    if (photic_bent_hit.object >= 0) face = photic_bent_hit.along * length(photic_bent_ray.momentum);
    if (face < nearest) nearest = face, next = photic_bent_hit.object;
    bool meets = next >= 0 && next == photic_bent_hit.object;
    if (next < 0 && photic_bent_inside != 0) {
        // No face behind it, though it is in a shape: through a hole of the mesh.
        photicBentInto(0);
        photicBentBegin(place, direction, photic_bent_ray.weight, -1);
        return false;
    }
#endif
    vec3 radiance;
    if (photicNearby(photic_bent_ray.start, direction, next < 0 ? 1e30 : nearest + distance(place, photic_bent_ray.start), radiance)) {
        photic_bent_sum += photic_bent_ray.weight * radiance;
        return true;
    }
    if (next < 0) {
        photic_bent_sum += photic_bent_ray.weight * photicEnvironment(direction);
        return true;
    }
    vec3 entry = place + nearest * direction;
#ifdef PHOTIC_BENT_SHAPES
    photicBentPass(photic_bent_base_absorption, vec3(0.0), nearest, n * n);
    photicBentBegin(entry, direction * n, photic_bent_ray.weight, meets ? -1 : next);
    if (meets) {
        photic_bent_ray.look = PHOTIC_BENT_MET;
        return false;
    }
#else
    photicBentBegin(entry, direction, photic_bent_ray.weight, next);
#endif
    if (photic_bent_objects[next].box_low.w != 0.0) photic_bent_ray.look = PHOTIC_BENT_ENTER;
    return false;
}

/// Radiance that arrives at a place from a direction, the objects in between.
/// @param place      relative to photic_bent_origin
/// @param direction  unit, away from the eye
/// @param channels   of the light, 0 or 1 each
/// @param channel    whose index bends it: 0 to 2
/// @param touched    whether anything but air was met
vec3 photicBentRadiance(vec3 place, vec3 direction, vec3 channels, int channel, out bool touched) {
    photic_bent_sum = vec3(0.0);
    photic_bent_pending = 0;
    photic_bent_touched = false;
    photic_bent_stretch = 0.0;
#ifdef PHOTIC_BENT_COUNTS
    photic_bent_looks = ivec4(0);
#endif
#ifdef PHOTIC_BENT_SHAPES
    photic_bent_channel = channel;
    photic_bent_asked = photicBentBoxesAround(place);
    photicBentInto(0);
    photicBentBegin(place, direction, channels, -1);
    photic_bent_ray.look = PHOTIC_BENT_BORN;
#else
    int object = photicBentFind(place);
    photicBentBegin(place, direction, channels, object);
    if (object >= 0) photic_bent_ray.look = PHOTIC_BENT_START;
#endif
    bool done = false;
    for (int i = 0; i < photic_bent_counts.y && !done; ++i) {
#ifdef PHOTIC_BENT_SHAPES
        // Each once in the text: compilers copy them to wherever they are called.
        if (photic_bent_ray.look == PHOTIC_BENT_MET) photicBentMeet();
        if (photic_bent_ray.look == PHOTIC_BENT_CROSS) photicBentCrossShape();
        photicBentSearch();
        if (photic_bent_ray.look == PHOTIC_BENT_BORN) {
            photicBentBorn();
            continue;
        }
#endif
        if (photic_bent_ray.object >= 0) {
            photicBentLook(channel);
            continue;
        }
        if (!photicBentFree()) continue;
        if (photic_bent_pending == 0) {
            done = true;
        } else {
            --photic_bent_pending;
            vec3 from = photic_bent_places[photic_bent_pending];
#ifdef PHOTIC_BENT_SHAPES
            photicBentInto(photic_bent_insides[photic_bent_pending]);
#endif
            photicBentBegin(from, photic_bent_ways[photic_bent_pending], photic_bent_weights[photic_bent_pending],
                            photicBentSamples(from));
        }
    }
    // What has had its steps sees the environment.
    if (!done) photic_bent_sum += photic_bent_ray.weight * photicEnvironment(normalize(photic_bent_ray.momentum));
    for (int i = 0; i < photic_bent_pending; ++i)
        photic_bent_sum += photic_bent_weights[i] * photicEnvironment(normalize(photic_bent_ways[i]));
    touched = photic_bent_touched;
    return photic_bent_sum;
}
