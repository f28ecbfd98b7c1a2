// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/version.h"

namespace photic {

const std::string& programVersion() {
    static const std::string version = PHOTIC_VERSION;
    return version;
}

const std::string& programName() {
    static const std::string name = "photic " + programVersion();
    return name;
}

}  // namespace photic
