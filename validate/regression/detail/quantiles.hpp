#pragma once

namespace klang::validate::detail {

/// z with P(|Z| > z) = probability for a standard normal Z; 0 < probability < 1.
double normal_two_sided(double probability);

/// t with P(|T| > t) = probability for Student's T with degrees_of_freedom > 0; infinity gives normal_two_sided.
double student_two_sided(double probability, double degrees_of_freedom);

}  // namespace klang::validate::detail
