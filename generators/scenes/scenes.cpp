#include "generators/scenes/scenes.h"

#include <map>
#include <mutex>

namespace lcpbench {

std::shared_ptr<const ScenesFile> open_collected(const CollectedScene& scene) {
  static std::mutex mutex;
  static std::map<std::string, std::shared_ptr<const ScenesFile>> opened;
  const std::lock_guard lock(mutex);
  std::shared_ptr<const ScenesFile>& file = opened[scene.name];
  if (!file) file = std::make_shared<ScenesFile>(scene.bytes, scene.name);
  return file;
}

}  // namespace lcpbench
