// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace photic::truth {

/// The standard normal deviate that is as unlikely as Student's t with `freedom` degrees: a mean over n repeats divided
/// by a standard error from the same repeats follows t with n - 1 degrees, whose square has mean (n-1)/(n-3), not 1.
double normalFromStudent(double t, int freedom);

/// Upper tail of Student's t: the probability of a value above t >= 0.
double studentTail(double t, int freedom);
/// Upper tail of the standard normal.
double normalTail(double z);

}  // namespace photic::truth
