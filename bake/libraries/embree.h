// SPDX-License-Identifier: Apache-2.0
/// Embree 3.13 (Debian 12) to 4.4: its headers, and the call that the two write differently.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace photic::embree {

/// The nearest hit of a ray that goes another way than its neighbours.
inline void intersect(RTCScene scene, RTCRayHit& query) {
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect1(scene, &query, &arguments);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);  // incoherent
    rtcIntersect1(scene, &context, &query);
#endif
}

}  // namespace photic::embree
