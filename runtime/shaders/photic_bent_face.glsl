// SPDX-License-Identifier: Apache-2.0
// Faces, of photic_bent_trace.glsl: what their coats send back, where they are, and how light is refracted there.

#ifdef PHOTIC_LIT
/// What baked light sends off a face towards the eye: Lambert's share, and a highlight after Cook and Torrance with GGX
/// (Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007).
/// @param coat    albedo and alpha
/// @param normal  unit, to the side of the eye
/// @param momentum  of the eye's ray as it comes
/// @param beyond    n^2 on the other side; negative: the ray is reflected totally
vec3 photicBentShine(vec4 coat, vec3 place, vec3 normal, vec3 momentum, float beyond) {
    float square = dot(momentum, momentum);
    PhoticLight light = photicSample(place + photic_bent_origin.xyz);
    float arrives = -dot(normal, light.flux);
    if (!(light.mean > 0.0) || arrives <= 0.0) return vec3(0.0);
    vec3 brdf = coat.rgb * 0.31830988618;
    vec3 to_light = -normalize(light.flux), to_eye = -normalize(momentum), halfway = normalize(to_light + to_eye);
    float nl = dot(normal, to_light), nv = dot(normal, to_eye);
    if (coat.w > 0.0 && nv > 0.0) {
        float a2 = coat.w * coat.w, nh = dot(normal, halfway), lh = dot(to_light, halfway), d = nh * nh * (a2 - 1.0) + 1.0;
        float before = sqrt(square) * lh, after2 = beyond - square + before * before;
        float fresnel = after2 > 0.0 ? photicFresnel(before, sqrt(after2), square, beyond) : 1.0;
        float shadows = 0.5 / (nl * sqrt(a2 + (1.0 - a2) * nv * nv) + nv * sqrt(a2 + (1.0 - a2) * nl * nl));
        brdf += fresnel * shadows * a2 / (3.14159265359 * d * d);
    }
    return brdf * light.irradiance * (arrives / light.mean * photicBasic(square));
}
#endif

/// Adds what the coat of a face sends back. @return its albedo, by which what goes on is less
/// @param node    of the face
/// @param place   beside it, on the eye's side, where light is looked up
/// @param beyond  n^2 on the other side; negative: the ray is reflected totally
/// @param weight  of the ray before the face
vec3 photicBentReflect(int object, vec3 node, vec3 place, vec3 normal, vec3 momentum, float beyond, vec3 weight) {
    vec4 coat = photicBentCoat(object, node);
    if (coat == vec4(0.0)) return vec3(0.0);
    vec3 sent = coat.rgb * photicBentAmbient(normal);
#ifdef PHOTIC_LIT
    sent += photicBentShine(coat, place, normal, momentum, beyond);
#endif
    photic_bent_sum += weight * sent;
    photic_bent_touched = true;
    return coat.rgb;
}

#ifndef PHOTIC_EULER
#define PHOTIC_BENT_PACE 0.9  // of the search for a face along a ray [nodes]

/// A length of the ray in one medium, on one side of a face.
void photicBentLength(int object, vec3 from, vec3 to, vec3 in_medium, float square) {
    PhoticBentMedium medium = photicBentMedium(object, photicBentNode(object, in_medium));
#ifdef PHOTIC_LIT
    photicBentScatter(medium, 0.5 * (from + to), distance(from, to), square);
#endif
    photicBentPass(medium.absorption + medium.scattering, medium.emission, distance(from, to), square);
}

/// Refracts and reflects the ray at the face that has been found.
/// @param gradient  there
void photicBentCross(int object, vec3 gradient) {
    vec3 from = photic_bent_ray.start, p = photic_bent_ray.momentum, face = from + photic_bent_face.peak * photic_bent_face.way;
    // On the way to it the ray bends as the index before it says.
    float s = photic_bent_face.peak * length(photic_bent_face.way) / length(p);
    float square = dot(p, p) + 2.0 * dot(photic_bent_face.near, face - from), beyond = 1.0 + 2.0 * photic_bent_face.far;
    p = normalize(p + s * photic_bent_face.near) * sqrt(square);
    // Of the slope there, what is beside the face is not the face's.
    vec3 normal = normalize(gradient - 0.5 * (photic_bent_face.near + photic_bent_face.beyond));
    float a = dot(p, normal);
    if (a < 0.0) normal = -normal, a = -a;
    vec3 along = p - a * normal, mirrored = along - a * normal;
    float b2 = beyond - dot(along, along);
    photicBentLength(object, from, face, from, square);
    photic_bent_touched = true;
    vec3 beside = face + s * mirrored;  // as far from the face as the ray was
    photic_bent_ray.weight *=
        1.0 - photicBentReflect(object, photicBentNode(object, face), from, -normal, p, beyond, photic_bent_ray.weight);
    if (b2 <= 0.0) {
        photicBentBegin(beside, mirrored, photic_bent_ray.weight, photicBentHolds(object, photicBentNode(object, beside)) ? object : -2);
        return;
    }
    float share = photicFresnel(a, sqrt(b2), square, beyond);
    photicBentPush(beside, mirrored, photic_bent_ray.weight * share);
    photic_bent_ray.weight *= 1.0 - share;
    // Behind it to where its width ends, and as much bent as the index there says.
    vec3 onward = along + sqrt(b2) * normal;
    float nodes = photic_bent_face.probe / max(sqrt(b2 / beyond), 0.2);
    float t = nodes * length(photic_bent_face.normal) / length(onward);
    vec3 place = face + t * onward, kicked = onward + t * photic_bent_face.beyond;
    photicBentLength(object, face, place, place, beyond);
    onward = normalize(kicked) * sqrt(max(beyond + 2.0 * dot(photic_bent_face.beyond, place - face), 1e-3));
    photicBentBegin(place, onward, photic_bent_ray.weight,
                    photicBentHolds(object, photicBentNode(object, place)) ? object : -2);
}

/// The search for a face begins: where the ray comes from another one, there, since they may be close; otherwise at the
/// look in the middle of the step that was about to be taken. @param force  there
void photicBentSeekFrom(vec3 force, bool fresh) {
    float a_node = length(photicBentNodeVector(photic_bent_ray.object, photic_bent_ray.momentum));
    float strength = length(force);
    photic_bent_face.way = photic_bent_ray.momentum / a_node;
    photic_bent_face.before = 1e30;
    photic_bent_face.met = false;
    photic_bent_ray.look = PHOTIC_BENT_SEEK;
    // What bends beside the face does so up to it; what grows within a step is the face's own width.
    photic_bent_face.near = strength < 2.0 * length(photic_bent_ray.force) ? photic_bent_ray.force : vec3(0.0);
    photic_bent_face.along = fresh ? 0.0 : 0.5 * photic_bent_ray.step * a_node + PHOTIC_BENT_PACE;
    photic_bent_face.last = fresh ? 1e30 : strength;
    photic_bent_face.passed = fresh ? vec3(0.0) : (photic_bent_face.along / PHOTIC_BENT_PACE) * force;
}

/// No face there, or none that the ray meets: the search goes on.
void photicBentSeekOn() { photic_bent_ray.look = PHOTIC_BENT_SEEK; }

/// What a look at the index around a face is for. @param here  the index at `place`
void photicBentSeek(int object, vec3 place, vec3 node, PhoticRefraction here) {
    float before = 0.5 * dot(photic_bent_ray.momentum, photic_bent_ray.momentum) - 0.5;
    float jump = photic_bent_face.far - before, middle = 0.5 * (before + photic_bent_face.far);
    if (photic_bent_ray.look == PHOTIC_BENT_SEEK) {
        bool holds = photicBentHolds(object, node), face = holds && photicBentFace(object, node);
        float strength = length(here.gradient), t = photic_bent_face.along;
        if (t == 0.0 && !face) photic_bent_face.near = here.gradient;
        bool stopped = false;
#ifdef PHOTIC_BENT_SHAPES
        // A sharp face ends the search, a hair before it.
        float until = photic_bent_hit.along * length(photic_bent_ray.momentum) / length(photic_bent_face.way) - 1e-3;
        stopped = photic_bent_hit.object >= 0 && t >= until;
        if (stopped) t = max(until, 0.0), place = photic_bent_ray.start + t * photic_bent_face.way;
#endif
        if ((t > 0.0 && !face) || t > 24.0 || stopped) {
            // Past all of it: straight on along a face that it does not meet, otherwise bent by what is beside faces.
            vec3 p = photic_bent_ray.momentum;
            float square = dot(p, p), s = PHOTIC_BENT_PACE * length(photic_bent_face.way) / sqrt(square);
            for (float done = 0.0; done < t; done += 1.0) {
                vec3 low = photic_bent_ray.start + done * photic_bent_face.way;
                vec3 high = photic_bent_ray.start + min(done + 1.0, t) * photic_bent_face.way;
                photicBentLength(object, low, high, 0.5 * (low + high), square);
            }
            vec3 bent = photic_bent_face.met ? p : p + s * photic_bent_face.passed;
            photicBentBegin(place, bent, photic_bent_ray.weight, holds ? object : -2);
            return;
        }
        if (t > 1.9 * PHOTIC_BENT_PACE && strength < photic_bent_face.last && photic_bent_face.last >= photic_bent_face.before) {
            // Between the three places the gradient is a Gaussian, nearly.
            vec3 three = log(max(vec3(photic_bent_face.before, photic_bent_face.last, strength), 1e-4 * photic_bent_face.last));
            float aside = 0.5 * (three.z - three.x) / max(2.0 * three.y - three.x - three.z, 1e-6);
            photic_bent_face.peak = t + PHOTIC_BENT_PACE * (clamp(aside, -1.0, 1.0) - 1.0);
            photic_bent_ray.look = PHOTIC_BENT_PEAK;
            photic_bent_face.met = true;
        }
        photic_bent_face.passed += here.gradient;
        photic_bent_face.before = photic_bent_face.last;
        photic_bent_face.last = strength;
        photic_bent_face.along = t + PHOTIC_BENT_PACE;
    } else if (photic_bent_ray.look == PHOTIC_BENT_PEAK) {
        vec3 normal = here.gradient / max(length(here.gradient), 1e-12);
        float cosine = dot(normal, photic_bent_ray.momentum) / length(photic_bent_ray.momentum);
        if (cosine < 0.0) normal = -normal;
        if (abs(cosine) < 0.02) {
            photicBentSeekOn();  // it only comes near
            return;
        }
        photic_bent_face.normal = normal / length(photicBentNodeVector(object, normal));
        photic_bent_face.excess = photic_bent_face.far = here.excess;
        photic_bent_face.slope = dot(here.gradient, photic_bent_face.normal);
        photic_bent_face.way_slope = dot(here.gradient, photic_bent_face.way);
        photic_bent_face.probe = 1.0;
        photic_bent_face.settled = false;
        photic_bent_ray.look = PHOTIC_BENT_PROBE;
    } else if (photic_bent_ray.look == PHOTIC_BENT_PROBE) {
        float slope = dot(here.gradient, photic_bent_face.normal) / photic_bent_face.slope;
        if (slope < 0.0) {
            // The other side of a thin wall begins: as far as the index came.
            if ((here.excess - photic_bent_face.far) * photic_bent_face.slope > 0.0) photic_bent_face.far = here.excess;
            photic_bent_face.beyond = vec3(0.0);
            photic_bent_face.probe -= 0.5;
        } else if (photic_bent_face.settled || photic_bent_face.probe >= 6.0) {
            // What changes here still does so beside the face too.
            photic_bent_face.far = here.excess - slope * photic_bent_face.slope * photic_bent_face.probe;
            photic_bent_face.beyond = here.gradient;
        } else {
            photic_bent_face.far = here.excess;
            photic_bent_face.settled = slope < 0.05;
            photic_bent_face.probe += 1.0;
            return;
        }
        jump = photic_bent_face.far - before;
        middle = 0.5 * (before + photic_bent_face.far);
        if (jump * photic_bent_face.slope <= 0.0 || abs(jump) < 0.002 || abs(photic_bent_face.excess - middle) > 0.4 * abs(jump)) {
            photicBentSeekOn();
            return;
        }
        photic_bent_face.peak += clamp((middle - photic_bent_face.excess) / photic_bent_face.way_slope, -1.0, 1.0);
        photic_bent_ray.look = PHOTIC_BENT_LAND;
    } else {
        float off = middle - here.excess, way_slope = dot(here.gradient, photic_bent_face.way);
        if (abs(off) > 0.2 * abs(jump) || way_slope * jump <= 0.0) {
            photicBentSeekOn();
            return;
        }
        photic_bent_face.peak = max(photic_bent_face.peak + clamp(off / way_slope, -0.3, 0.3), 0.0);
        photicBentCross(object, here.gradient);
    }
}
#endif
