#include "can/frame.h"
