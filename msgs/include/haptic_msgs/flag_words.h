/// The flags of a device and of a step in words, for people.
#pragma once
#include "haptic_core/spidar/device_diagnosis.h"
#include "haptic_core/world/report.h"

namespace haptic {

/// How much a flag asks of whoever sees it.
enum class FlagGrade : unsigned char {
  kNote,     ///< a limit does its work
  kWarning,  ///< something is not as it should be
};

/// One bit.
struct FlagWords {
  unsigned flag;     ///< the bit
  const char* name;  ///< as reports and `./run shrink --fault` call it
  FlagGrade grade;   ///< how much it asks of whoever sees it
  const char* text;  ///< a sentence for people
};

/// Each bit of DeviceFlag.
inline constexpr FlagWords kDeviceFlagWords[] = {
    {kCommandNotFinite, "CommandNotFinite", FlagGrade::kWarning, "a wrench was not finite"},
    {kForceClamped, "ForceClamped", FlagGrade::kNote, "the force is held at the device's limit"},
    {kTorqueClamped, "TorqueClamped", FlagGrade::kNote, "the torque is held at the device's limit"},
    {kSlewLimited, "SlewLimited", FlagGrade::kNote, "the force changes as fast as it may"},
    {kNotPresentable, "NotPresentable", FlagGrade::kWarning, "the wrench cannot be presented"},
    {kTensionAtMax, "TensionAtMax", FlagGrade::kWarning, "a string pulls at its greatest tension"},
    {kFaded, "Faded", FlagGrade::kNote, "the force is faded"},
    {kCommandStale, "CommandStale", FlagGrade::kNote, "no fresh wrench comes"},
    {kTorqueIgnored, "TorqueIgnored", FlagGrade::kWarning, "a point grip: torque is ignored"},
    {kPoseNotConverged, "PoseNotConverged", FlagGrade::kWarning, "the pose was not found"},
    {kSampleStale, "SampleStale", FlagGrade::kNote, "a board sent no new counts"},
    {kLinkLost, "LinkLost", FlagGrade::kWarning, "the device does not answer"},
    {kEncoderJump, "EncoderJump", FlagGrade::kWarning, "an encoder jumped"},
    {kResidualHigh, "ResidualHigh", FlagGrade::kWarning, "the string lengths contradict each other"},
    {kOverRate, "OverRate", FlagGrade::kNote, "the loop is faster than the wire"},
    {kMotorHot, "MotorHot", FlagGrade::kNote, "a motor is hot: the force is faded"},
    {kAnswersLost, "AnswersLost", FlagGrade::kWarning, "answers of the boards are lost"},
    {kDelayTooLong, "DelayTooLong", FlagGrade::kWarning, "the wire is too slow for force"},
    {kCountersStill, "CountersStill", FlagGrade::kNote, "no counter moves although the force does"},
    {kCounterRestarted, "CounterRestarted", FlagGrade::kWarning, "a board started anew"},
    {kStringCorrected, "StringCorrected", FlagGrade::kWarning, "an encoder slipped and was corrected"},
    {kCountRefused, "CountRefused", FlagGrade::kWarning, "a count was refused"},
    {kLoopLate, "LoopLate", FlagGrade::kNote, "this computer was late"},
    {kCountersFrozen, "CountersFrozen", FlagGrade::kNote, "all counters stopped at once"},
    {kSomeCountersStill, "SomeCountersStill", FlagGrade::kNote, "the counters of one board stand still"},
    {kCalibrationRefused, "CalibrationRefused", FlagGrade::kNote, "calibration refused: the grip was not at home"},
    {kUnguarded, "Unguarded", FlagGrade::kWarning, "no motor guard watches"},
    {kStopped, "Stopped", FlagGrade::kWarning, "somebody said STOP"},
    {kReleased, "Released", FlagGrade::kWarning, "the dead-man switch is not held"},
    {kForceWaits, "ForceWaits", FlagGrade::kNote, "the force waits until somebody enables it"},
};

/// Each bit of StepFlag.
inline constexpr FlagWords kStepFlagWords[] = {
    {kPairsDropped, "PairsDropped", FlagGrade::kWarning, "too many bodies meet: some contacts are left out"},
    {kContactsIncomplete, "ContactsIncomplete", FlagGrade::kNote, "a contact is too detailed: faces are left out"},
    {kNormalRemembered, "NormalRemembered", FlagGrade::kNote, "a contact keeps its last direction"},
    {kNotConverged, "NotConverged", FlagGrade::kWarning, "the step did not converge: shorten it"},
    {kPressureClipped, "PressureClipped", FlagGrade::kNote, "a contact would have pulled"},
    {kJointsNotConverged, "JointsNotConverged", FlagGrade::kWarning, "a joint's force is not what its law says: shorten the step"},
    {kDissipationGave, "DissipationGave", FlagGrade::kNote, "a damper gave energy: shorten the step"},
    {kTooFast, "TooFast", FlagGrade::kWarning, "a body is too fast for its thickness: shorten the step"},
    {kImpactUnresolved, "ImpactUnresolved", FlagGrade::kNote, "an impact was too short for the step"},
    {kRunaway, "Runaway", FlagGrade::kWarning, "the steps made energy: shorten the step"},
    {kGaveWay, "GaveWay", FlagGrade::kNote, "work was left out to be in time"},
};

}  // namespace haptic
