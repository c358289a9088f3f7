#include "cli/app/application.h"
#include "cli/base/interrupt.h"

int main(int argc, char** argv) {
  cansync::cli::install_interrupt_handlers();
  return static_cast<int>(cansync::cli::run(argc, argv, stdout, stderr));
}
