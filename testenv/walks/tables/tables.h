// The tables of subsurface scattering.
#pragma once

#include "testenv/support/table_report.h"

namespace alabaster::testing {

void print_slab_albedo(Report& report);
void print_radial_profile(Report& report);
void print_diffusion_profile(Report& report);
void print_chromatic_walks(Report& report);
void print_shortcuts(Report& report);
void print_analytic_bodies(Report& report);
void print_mesh_bodies(Report& report);
void print_rendered_bodies(Report& report);
void print_extremes(Report& report);
void print_anisotropy(Report& report);
void print_energy(Report& report);

}  // namespace alabaster::testing
