#include "cansync/numbers.h"
