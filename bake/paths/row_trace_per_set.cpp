// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/row_trace_impl.h"

namespace photic::PHOTIC_ISA {

RowTracer rowTracerHere() { return traceRow; }

}  // namespace photic::PHOTIC_ISA
