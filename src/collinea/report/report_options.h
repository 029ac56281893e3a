// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/options.h"

namespace collinea {

/// Who answers for a report: what its signature block says. Empty: a line to fill in by hand.
struct ReportOptions {
  std::string surveyor;
  std::string licence;
  std::string signed_on;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ReportOptions;
    visit(Field{"surveyor", &O::surveyor, "", "name of who signs the report; nothing: a line to fill in"});
    visit(Field{"licence", &O::licence, "", "licence or register number of who signs; nothing: a line to fill in"});
    visit(Field{"signed_on", &O::signed_on, "",
                "date of the signature, as it shall be printed; nothing: a line to fill in"});
  }
};

}  // namespace collinea
