// SPDX-License-Identifier: Apache-2.0
/// Embree 3.13 (Debian 12) to 4.4: its headers, and the calls that the two write differently.
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

/// A scene whose rays visitHits() follows needs it.
#if RTC_VERSION_MAJOR >= 4
inline constexpr RTCSceneFlags kVisitable = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
using QueryContext = RTCRayQueryContext;
inline void begin(QueryContext& context) { rtcInitRayQueryContext(&context); }
#else
inline constexpr RTCSceneFlags kVisitable = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
using QueryContext = RTCIntersectContext;
inline void begin(QueryContext& context) { rtcInitIntersectContext(&context); }
#endif

/// Calls visit(geometry, distance, cosine) for every hit of a ray, in no order; the cosine is that of the angle between
/// ray and face, times any positive number. The query itself hits nothing.
template <class Visit>
void visitHits(RTCScene scene, RTCRayHit& query, Visit& visit) {
    struct Context : QueryContext {
        Visit* visit;
    } context;
    begin(context);
    context.visit = &visit;
    const RTCFilterFunctionN each = [](const RTCFilterFunctionNArguments* a) {
        const auto& visiting = *static_cast<const Context*>(static_cast<const QueryContext*>(a->context));
        for (unsigned i = 0; i < a->N; ++i) {
            if (a->valid[i] == 0) continue;
            (*visiting.visit)(RTCHitN_geomID(a->hit, a->N, i), RTCRayN_tfar(a->ray, a->N, i),
                              RTCRayN_dir_x(a->ray, a->N, i) * RTCHitN_Ng_x(a->hit, a->N, i) +
                                  RTCRayN_dir_y(a->ray, a->N, i) * RTCHitN_Ng_y(a->hit, a->N, i) +
                                  RTCRayN_dir_z(a->ray, a->N, i) * RTCHitN_Ng_z(a->hit, a->N, i));
            a->valid[i] = 0;  // and on
        }
    };
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags =
        static_cast<RTCRayQueryFlags>(RTC_RAY_QUERY_FLAG_INCOHERENT | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
    arguments.context = &context;
    arguments.filter = each;
    rtcIntersect1(scene, &query, &arguments);
#else
    context.filter = each;
    rtcIntersect1(scene, &context, &query);
#endif
}

}  // namespace photic::embree
