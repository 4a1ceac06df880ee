// Compares the subsurface walk with theory, measures its cost, and prints both as Markdown.
//   subsurface_tables --quick | --long [--table NAME]...
// --quick (some twenty seconds) runs in the test suite, --long made testenv/statistical/results/subsurface.md.
// Exit status: 0 all comparisons hold, 1 some do not, 2 wrong usage.
#include <cstdio>
#include <cstring>
#include <string>

#include "testenv/statistical/tables/report.h"

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

// Standard errors of quantities between 0 and 1.
constexpr double kQuickSigma = 2e-3, kLongSigma = 2e-4;

const Table* find_table(const char* name) {
  for (const Table& table : kTables)
    if (std::strcmp(table.name, name) == 0) return &table;
  return nullptr;
}

int usage() {
  std::fprintf(stderr, "usage: subsurface_tables --quick | --long [--table NAME]...\ntables:");
  for (const Table& table : kTables) std::fprintf(stderr, " %s", table.name);
  std::fprintf(stderr, "\n");
  return 2;
}

int run(int argc, char** argv) {
  double sigma = 0;
  std::vector<const Table*> wanted;
  std::string command = "build/release/bin/subsurface_tables";
  for (int i = 1; i < argc; ++i) {
    command += std::string(" ") + argv[i];
    if (std::strcmp(argv[i], "--quick") == 0) {
      sigma = kQuickSigma;
    } else if (std::strcmp(argv[i], "--long") == 0) {
      sigma = kLongSigma;
    } else if (std::strcmp(argv[i], "--table") == 0 && i + 1 < argc && find_table(argv[i + 1])) {
      wanted.push_back(find_table(argv[++i]));
      command += std::string(" ") + argv[i];
    } else {
      return usage();
    }
  }
  if (!(sigma > 0)) return usage();
  if (wanted.empty())
    for (const Table& table : kTables) wanted.push_back(&table);

  std::printf("# Measured against theory\n\nMade by `%s`.\n", command.c_str());
  Report report(sigma);
  for (const Table* table : wanted) table->print(report);
  return report.verdict() ? 0 : 1;
}

}  // namespace
}  // namespace alabaster::testing

int main(int argc, char** argv) {
  return alabaster::testing::run(argc, argv);
}
