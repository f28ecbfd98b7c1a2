// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

namespace photic {

/// While this lives, what stands in the scene that was traced last is not built again for scenes with the very same
/// shapes: an estimate, the choice of lobes and the bake itself each ask for it.
class KeptShapes {
public:
    KeptShapes();
    ~KeptShapes();

private:
    struct Held;
    std::unique_ptr<Held> held_;
};

}  // namespace photic
