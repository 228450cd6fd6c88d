#include "haptic_core/dynamics/joint_type.h"

namespace haptic {

Quaternion turnFromZ(const Vector3& a) { return Quaternion::FromTwoVectors(Vector3::UnitZ(), a); }

}  // namespace haptic
