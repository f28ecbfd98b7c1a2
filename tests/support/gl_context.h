// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "runtime/headless/headless_gl.h"

namespace photic::test {

using runtime::GlApi;
using runtime::HeadlessGl;

}  // namespace photic::test
