#include "delegate/view/window.h"

int main(int argc, char** argv) {
  return alabaster::view::run_program(argc, argv);
}
