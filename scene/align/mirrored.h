#pragma once
// Scans whose axes are left-handed: some exports turn one round.

#include "scene/align/register_pair.h"

namespace scene {

/// The same scan with its x axis turned round.
ScanView mirrored(const ScanView& view);

/// Whether b fits a once it is mirrored. To be asked where it does not fit as it is.
bool isMirrorOf(const ScanView& a, const ScanView& b, const PairOptions& options);

} // namespace scene
