// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "bake/image/colour_map.h"
#include "bake/image/image.h"

namespace photic {

/// sRGB's encoding of a linear value (IEC 61966-2-1), clamped to 0..1.
double encodeSrgb(double linear);

/// The mean of a pixel's colour channels (alpha left out).
double pixelMean(const Image& image, int x, int y);

/// The value that `fraction` of the pixels' means stay below; pixels with alpha 0 don't count. 0 for an empty image.
double percentile(const Image& image, double fraction);

/// Rounds up to 1, 1.5, 2, 3, 4, 5, 6, 8 x a power of ten; 1 for values that are not positive.
double niceCeiling(double value);

/// Linear display of irradiance: `white` [the image's unit] becomes display white, brighter values clip.
/// 1 or 3 channels in, RGB out, sRGB encoded.
Image displayLinear(const Image& image, double white);

/// Filmic display of radiance (fit of the ACES curve by K. Narkowicz, 2015), sRGB encoded; alpha is laid over a quiet
/// gradient. @param exposure  1 / [the image's unit]
Image displayFilmic(const Image& radiance, double exposure);

/// The mean of the channels through a colour map, min..max, with a labelled colour bar to the right.
/// @param unit  written above the bar, for instance "W/m2"
Image displayMapped(const Image& image, ColourMap map, double min, double max, const std::string& unit);

/// Repeats pixels so that the shorter side reaches `pixels`, while the longer one has no more than four times as many:
/// a band of four voxels that is seen from its side would be a hundred times as long. `aspect` stretches the height
/// (voxels that are not cubes).
Image enlarge(const Image& image, int pixels, double aspect = 1);

/// Pictures side by side from left to right, `columns` a row, each with its caption below; dark gaps between them.
/// @throws Error{Input} when there is none
Image filmStrip(const std::vector<Image>& pictures, const std::vector<std::string>& captions, int columns);

}  // namespace photic
