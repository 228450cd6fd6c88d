// Pairs of shapes: rods against an integration in more bits, what they cost beside boxes, how logs stand and roll,
// the energy of an ellipsoid that spins, the inner edges of ground, and heaps of round bodies beside peers.
#include <cstdlib>
#include <cstring>

#include "heap_kinds.h"
#include "shapes_figures.h"

int main(int count, char** arguments) {
  using namespace haptic::bench;
  using haptic::scenes::HeapKind;
  if (count == 4 && std::strcmp(arguments[1], "--count") == 0) {
    countRodPass(arguments[2], std::atoi(arguments[3]));
    return 0;
  }
  const auto wanted = [&](const char* group) {
    return count < 2 || std::strstr(group, arguments[1]) != nullptr;
  };
  if (wanted("cost")) measureRodCost();
  if (wanted("jumps")) measureRodJumps(20000);
  if (wanted("overhang")) measureOverhang();
  if (wanted("terrain")) measureTerrain();
  if (wanted("ellipsoid")) measureEllipsoid();
  if (wanted("logs")) measureLogs();
  for (const HeapKind kind : {HeapKind::kTubes, HeapKind::kRound}) {
    if (!wanted("heaps")) break;
    for (const int count : {10, 100}) measureHeapOf(kind, count);
  }
  const bool one_kind = count > 1 && std::strncmp(arguments[1], "accuracy_", 9) == 0;
  if (one_kind || wanted("accuracy")) measureRodAccuracy(one_kind ? arguments[1] : nullptr, count > 2 ? std::atoi(arguments[2]) : 0);
}
