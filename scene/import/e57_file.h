#pragma once
// An E57 file opened with care: its sizes are proved and its XML is looked over before libE57Format sees it,
// and whatever libE57Format or its XML parser throws becomes a Failure in plain words. Only the e57*.cpp
// files include this.

#include "scene/pose.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <E57Format.h>

namespace scene {

/// Runs work and turns every exception of libE57Format, of its XML parser and of memory into a Failure about
/// path.
void withE57Failures(const std::filesystem::path& path, const std::function<void()>& work);

/// Opens a file for reading. Call within withE57Failures. Failure: not there, not a file, not E57, cut off,
/// an XML section that is not within the file, that declares entities or loads others, or is nested absurdly
/// deep.
e57::ImageFile openE57(const std::filesystem::path& path);

/// The child of that name, or nothing.
std::optional<e57::Node> childOf(const e57::StructureNode& parent, const std::string& name);

/// A number however the file writes it (Integer, ScaledInteger or Float); nothing if the child is absent or
/// no number.
std::optional<double> numberOf(const e57::StructureNode& parent, const std::string& name);

/// A text, or "" if absent.
std::string textOf(const e57::StructureNode& parent, const std::string& name);

/// fileFromLocal of the child "pose": identity where it is absent. Failure: not finite, or a quaternion of
/// length 0.
Pose poseOf(const e57::StructureNode& parent, const std::string& what, const std::filesystem::path& path);

/// The children of /data3D or /images2D; 0 if there is no such vector.
std::int64_t childCountOf(const e57::ImageFile& file, const std::string& vectorName);

/// One of them. Failure: there is none of that index.
e57::StructureNode structureAt(const e57::ImageFile& file, const std::string& vectorName, std::int64_t index,
                               const std::filesystem::path& path);

} // namespace scene
