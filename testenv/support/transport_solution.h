// Deterministic answers to transport problems of isotropic scatterers in an index-matched body, by solving the integral
// equation for the density of collisions (Galerkin, piecewise constant, Richardson extrapolation). Monte Carlo walks
// are compared with them. Lengths are in mean free paths.
#pragma once

namespace alabaster::testing {

struct SlabAnswer {
  double reflectance = 0, transmittance = 0;
  double error = 0;  // estimate of the quadrature error of either
};

/// A slab lit by a cosine lobe from one side.
SlabAnswer solve_slab(double thickness, double one_minus_alpha);

struct SphereAnswer {
  double albedo = 0;  // fractions of the entering light that come out
  double error = 0;
};

/// A sphere in uniform surroundings.
SphereAnswer solve_sphere(double radius, double one_minus_alpha);

/// Fraction of a cosine lobe that crosses without a collision.
double slab_zero_scatter(double thickness);  // 2 E3(L)
double sphere_zero_scatter(double radius);   // (1 - (1+2r) e^{-2r}) / (2 r^2)

}  // namespace alabaster::testing
