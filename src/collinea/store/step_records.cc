// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/step_records.h"

#include "collinea/store/internal/finding_values.h"
#include "collinea/store/packed_fields.h"

namespace collinea {
namespace {

constexpr std::uint8_t kFormat = 1;  // how packed_fields.h writes; the members have a fingerprint

template <class Record>
Result<StepOutcome> unpacked_record(Unpacker& unpacker) {
  const auto format = unpacker.get<std::uint8_t>();
  const auto members = unpacker.get<std::uint64_t>();
  if (format != kFormat || members != layout<Record>())
    return fail(Errc::kUnsupported,
                "written by another version of collinea: do the step " + std::string(Record::kStep) + " again");
  Record record;
  if (!unpack(unpacker, record) || !unpacker.done())
    return fail(Errc::kBadFormat, "damaged: the record of the step " + std::string(Record::kStep));
  return record;
}

// The alternatives of StepOutcome one after the other.
template <std::size_t Kind = 0>
Result<StepOutcome> unpacked_as(std::string_view step, Unpacker& unpacker) {
  if constexpr (Kind == std::variant_size_v<StepOutcome>) {
    return fail(Errc::kBadFormat, "damaged: there is no step " + std::string(step));
  } else {
    using Record = std::variant_alternative_t<Kind, StepOutcome>;
    return step == Record::kStep ? unpacked_record<Record>(unpacker) : unpacked_as<Kind + 1>(step, unpacker);
  }
}

}  // namespace

void PairCounts::add(PairGeometry geometry) {
  switch (geometry) {
    case PairGeometry::kNone:
      ++unrelated;
      break;
    case PairGeometry::kGeneral:
      ++general;
      break;
    case PairGeometry::kPlanar:
      ++planar;
      break;
    case PairGeometry::kRotation:
      ++rotation;
      break;
  }
}

std::string_view step_of(const StepOutcome& outcome) {
  return std::visit([](const auto& record) { return record.kStep; }, outcome);
}

std::optional<Finding> skipped_because(const StepOutcome& outcome) {
  return std::visit(
      [](const auto& record) -> std::optional<Finding> {
        if constexpr (requires { record.skipped_because; })
          return record.skipped_because;
        else
          return std::nullopt;
      },
      outcome);
}

std::string packed(const StepOutcome& outcome) {
  Packer packer;
  packer.put(kFormat);
  std::visit(
      [&]<class Record>(const Record& record) {
        packer.put(layout<Record>());
        pack(packer, record);
      },
      outcome);
  return packer.bytes();
}

Result<StepOutcome> unpacked_outcome(std::string_view step, std::string_view bytes) {
  Unpacker unpacker(bytes);
  return unpacked_as(step, unpacker);
}

}  // namespace collinea
