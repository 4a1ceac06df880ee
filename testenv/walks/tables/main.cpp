// Compares the subsurface walk with theory, measures its cost, and prints both as Markdown.
//   subsurface_tables --quick | --long [--table NAME]...
// --quick (some twenty seconds) runs in the test suite, --long made testenv/statistical/results/subsurface.md.
// Exit status: 0 all comparisons hold, 1 some do not, 2 wrong usage.
#include "testenv/walks/tables/tables.h"

namespace alabaster::testing {
namespace {

constexpr Table kTables[] = {
    {"slab_albedo", print_slab_albedo},
    {"radial_profile", print_radial_profile},
    {"diffusion_profile", print_diffusion_profile},
    {"chromatic_walks", print_chromatic_walks},
    {"shortcuts", print_shortcuts},
    {"analytic_bodies", print_analytic_bodies},
    {"mesh_bodies", print_mesh_bodies},
    {"rendered_bodies", print_rendered_bodies},
    {"extremes", print_extremes},
    {"anisotropy", print_anisotropy},
    {"energy", print_energy},
};

}  // namespace
}  // namespace alabaster::testing

int main(int argc, char** argv) {
  return alabaster::testing::print_tables(argc, argv, "Measured against theory", alabaster::testing::kTables);
}
