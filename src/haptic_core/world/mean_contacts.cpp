#include "haptic_core/world/mean_contacts.h"

#include <algorithm>

namespace haptic {
namespace {

/// Index of the same contact, looked for from `hint` on; the number of entries if there is none.
int find(const ContactReport& contact, int hint, const LoadedVector<ContactReport>& sums) noexcept {
  for (int k = 0; k < sums.size(); ++k) {
    const int i = hint + k < sums.size() ? hint + k : hint + k - sums.size();
    if (sums[i].shape_a == contact.shape_a && sums[i].shape_b == contact.shape_b) return i;
  }
  return sums.size();
}

}  // namespace

void addPart(double h, PartContacts& parts, Report& report) noexcept {
  if (!parts.any) parts.sums.clear();
  parts.any = true;
  int next = 0;
  for (const ContactReport& contact : report.contacts) {
    const int i = find(contact, std::min(next, parts.sums.size()), parts.sums);
    ContactReport sum = contact;
    sum.F_BP_W = contact.F_BP_W * h;
    if (i < parts.sums.size()) {
      const ContactReport& before = parts.sums[i];
      sum.F_BP_W += before.F_BP_W.shifted(contact.X_WP.p - before.X_WP.p);
      sum.event = std::min(sum.event, before.event);
      parts.sums[i] = sum;
    } else if (!parts.sums.push_back(sum)) {
      report.step.flags |= kContactsIncomplete;
    }
    next = i + 1;
  }
}

void reportParts(double h, PartContacts& parts, Report& report) noexcept {
  if (!parts.any) return;
  report.contacts.clear();
  for (ContactReport& contact : parts.sums) {
    contact.F_BP_W = contact.F_BP_W * (1 / h);
    contact.normal_force = contact.F_BP_W.force.dot(contact.X_WP.R.col(2));
    report.contacts.push_back(contact);
  }
  report.step.contacts = report.contacts.size();
  parts.any = false;
}

}  // namespace haptic
