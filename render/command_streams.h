#pragma once
// Where commands are recorded: per frame in flight and eye one pool, one command buffer and one fence, so
// that the eyes record at the same time and nobody waits but for the frame two before.

#include "render/device.h"
#include "render/handle.h"
#include "render/target.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace render {

/// A command buffer and the pool it alone is of, which is reset whole.
struct Recorder {
    CommandPool pool;
    VkCommandBuffer commands = VK_NULL_HANDLE;
};
Recorder makeRecorder(const Device& device);

Fence makeFence(const Device& device, VkFenceCreateFlags flags);

/// Where the eyes of a frame are submitted to.
enum class EyeQueues {
    own,  ///< each to its own, where there are two
    first ///< all to the first, one after the other, so that one may draw for both
};

class CommandStreams {
  public:
    CommandStreams(const Device& device, int eyes);
    /// Waits until nothing that was submitted is still running.
    ~CommandStreams();
    CommandStreams(const CommandStreams&) = delete;
    CommandStreams& operator=(const CommandStreams&) = delete;

    /// Waits until the frame that used this slot (0 to kFramesInFlight - 1) before has finished.
    void wait(std::size_t slot);
    /// Whether it has; does not wait.
    bool isDone(std::size_t slot) const;
    /// Waits for the frames of all slots: what they used may then go.
    void waitForAll();
    /// Starts an eye's commands anew; the slot must have been waited for. Different eyes may be recorded by
    /// different threads.
    VkCommandBuffer begin(std::size_t slot, int eye);
    /// Ends and submits all eyes of a slot, the left one first. Whatever is submitted to the first queue afterwards (by
    /// a headset's runtime) comes after both. After a frame on the first queue alone, one on both must wait for it.
    void submit(std::size_t slot, EyeQueues queues = EyeQueues::own);

  private:
    struct Stream {
        Recorder recorder;
        Fence finished;   ///< signalled while nothing is running
        Semaphore joined; ///< of an eye with a queue of its own: the first queue waits for it
    };
    const Device& device_;
    std::array<std::vector<Stream>, kFramesInFlight> slots_; ///< per eye
};

/// Records commands, submits them to the first queue and waits until they are done: for what happens once.
void runAndWait(const Device& device, const std::function<void(VkCommandBuffer)>& recordCommands);

/// What was written or read at some stages is finished and visible before others read or write.
struct Barrier {
    VkPipelineStageFlags fromStages = 0;
    VkAccessFlags fromAccess = 0;
    VkPipelineStageFlags toStages = 0;
    VkAccessFlags toAccess = 0;
};
void record(VkCommandBuffer commands, const Barrier& barrier);

} // namespace render
