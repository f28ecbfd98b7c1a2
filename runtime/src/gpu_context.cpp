// SPDX-License-Identifier: Apache-2.0
#include "photic/runtime_gl.h"
#include "runtime/src/gl_functions.h"
#include "runtime/src/guarded.h"

namespace photic::runtime {

Result<GpuContext> GpuContext::create(const GlLoader& loader) {
    return guarded([&]() -> Result<GpuContext> {
        Result<GlFunctions> gl = loadGlFunctions(loader);
        if (!gl) return gl.error();
        return GpuContext(std::make_shared<const GlFunctions>(std::move(*gl)));
    });
}

std::string GpuContext::renderer() const { return gl_->renderer; }

}  // namespace photic::runtime
