#pragma once

/// Marks what programs may use of the shared library libcansync; everything else stays inside it.
#define CANSYNC_PUBLIC __attribute__((visibility("default")))
