// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <string>

#include "bake/image/image.h"

namespace photic {

/// Draws text (ASCII) into a display image, `scale` pixels a font dot, top left at x, y; what lies outside is clipped.
/// Capitals are 7 dots high, a line 12.
void drawText(Image& image, int x, int y, const std::string& text, int scale, const glm::dvec3& colour);

/// Width of a line of text [pixels].
int textWidth(const std::string& text, int scale);

}  // namespace photic
