#define LCPBENCH_EIGEN_INSTANCE template
#include "core/eigen_instances.h"
