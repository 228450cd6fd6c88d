/// Eigen, as everything that includes the core has it: the one place where its alignment is fixed.
///
/// Eigen aligns fixed-size objects and heap storage by the instructions that a translation unit is compiled for: 16 bytes with
/// SSE, 32 with AVX, 64 with AVX-512. Poses, quaternions and vectors cross the border of the library, which is compiled for other
/// instructions than its users, so both agree on 16. Consequence: Eigen's own vectors of 32 bytes use unaligned loads.
#pragma once

#ifndef EIGEN_MAX_ALIGN_BYTES
#define EIGEN_MAX_ALIGN_BYTES 16         ///< of storage on the heap [bytes]
#define EIGEN_MAX_STATIC_ALIGN_BYTES 16  ///< of members and locals [bytes]
#endif
#include <Eigen/Core>
#include <Eigen/Geometry>

static_assert(EIGEN_MAX_ALIGN_BYTES == 16 && EIGEN_MAX_STATIC_ALIGN_BYTES == 16 && alignof(Eigen::Vector4d) == 16 &&
                  alignof(Eigen::Quaterniond) == 16,
              "Eigen was included with another alignment than haptic_core's: include a header of haptic_core before Eigen's, or "
              "compile with -DEIGEN_MAX_ALIGN_BYTES=16 -DEIGEN_MAX_STATIC_ALIGN_BYTES=16");
