// SPDX-License-Identifier: Apache-2.0
// How a medium scatters (Henyey and Greenstein 1941).

/// Henyey-Greenstein phase function [1/sr].
/// @param cosine  between the directions of travel before and after
float photicPhase(float cosine, float g) {
    // 1 + g^2 - 2 g cos, written so that it does not cancel for strongly forward scattering.
    float base = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cosine);
    return (1.0 - g * g) / (12.566370614 * base * sqrt(base));
}
