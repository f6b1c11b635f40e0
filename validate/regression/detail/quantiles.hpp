#pragma once

namespace klang::validate::detail {

/// z with P(|Z| > z) = probability for a standard normal Z; 0 < probability < 1.
double normal_two_sided(double probability);

/// t with P(|T| > t) = probability for Student's T with degrees_of_freedom > 0; infinity gives normal_two_sided.
double student_two_sided(double probability, double degrees_of_freedom);

/// P(F > f) for Fisher's F with d1 and d2 degrees of freedom.
double fisher_tail(double f, double d1, double d2);

}  // namespace klang::validate::detail
