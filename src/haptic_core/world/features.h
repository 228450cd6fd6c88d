/// What a build of the world can do beyond free bodies in contact. All of it, unless HAPTIC_PLAIN_WORLD is defined:
/// `./run bench plan` compiles the world a second time that way, to measure what features cost that a scene does not use.
/// The bodies must then be free, no hand holds one, no ledger is kept and the step is explicit.
#pragma once

namespace haptic {

#ifdef HAPTIC_PLAIN_WORLD
inline constexpr bool kFullWorld = false;
#else
inline constexpr bool kFullWorld = true;
#endif

}  // namespace haptic
