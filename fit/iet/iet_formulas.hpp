#pragma once

/// Closed forms of ASTM E1876 (impulse excitation of vibration); ISO 12680-1, EN 843-2 and ASTM C1259 have the same.
namespace klang::fit::e1876 {

struct Bar {
  double length_m = 0.0, width_m = 0.0, thickness_m = 0.0, mass_kg = 0.0;  ///< vibrates across its thickness
};
/// E = 0.9465 (m f^2 / b) (L^3 / t^3) T1 of the first flexural frequency, T1 (nu) the correction for finite thickness
/// (after Pickett and Spinner).
double bar_youngs_modulus_pa(const Bar& bar, double flexural_hz, double poissons_ratio);
/// G = (4 L m f^2 / (b t)) R of the first torsional frequency.
double bar_shear_modulus_pa(const Bar& bar, double torsional_hz);

struct Rod {
  double length_m = 0.0, diameter_m = 0.0, mass_kg = 0.0;
};
/// E = 1.6067 (L^3 / D^4) m f^2 T1'.
double rod_youngs_modulus_pa(const Rod& rod, double flexural_hz, double poissons_ratio);
/// G = 16 L m f^2 / (pi D^2).
double rod_shear_modulus_pa(const Rod& rod, double torsional_hz);

struct Disc {
  double diameter_m = 0.0, thickness_m = 0.0, mass_kg = 0.0;
};
/// E = 37.6991 f^2 D^2 m (1 - nu^2) / (K^2 t^3).
/// @param factor  K of the first (two nodal diameters) or second (one nodal circle) natural vibration, by nu and t/r
double disc_youngs_modulus_pa(const Disc& disc, double frequency_hz, double factor, double poissons_ratio);
/// K of a disc whose frequency and modulus are known: the inverse of the above.
double disc_factor(const Disc& disc, double frequency_hz, double youngs_modulus_pa, double poissons_ratio);

}  // namespace klang::fit::e1876
