// SPDX-License-Identifier: Apache-2.0
#include "bake/field/lobes.h"
#include "bake/file/vdb.h"

namespace photic {

LightVolume withoutLobes(LightVolume volume) {
    if (volume.second) addField(volume.field, *volume.second);
    volume.second.reset();
    volume.metadata.erase("lobe_axis");
    return volume;
}

}  // namespace photic
