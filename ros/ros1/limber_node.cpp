// SPDX-License-Identifier: MIT
// ROS 1: stereo images and IMU or odometry in, odometry, tf and diagnostics out. Parameters and topics:
// ros/README.md.
#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/TwistWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "node_core.hpp"

namespace {

constexpr unsigned kMostMessages = 5000;  // that wait for the node; more are lost

ros::Time to_ros(std::int64_t t_ns) { return ros::Time().fromNSec(static_cast<std::uint64_t>(t_ns)); }
std::int64_t from_ros(const ros::Time& time) { return static_cast<std::int64_t>(time.toNSec()); }

template <typename Message>
void set(Message& message, const std::array<double, 3>& v) {
  message.x = v[0];
  message.y = v[1];
  message.z = v[2];
}

/// Publishes what the core tells.
class Publisher final : public limber_node::Output {
 public:
  Publisher(ros::NodeHandle& node, const ros::NodeHandle& own)
      : odometry_(node.advertise<nav_msgs::Odometry>("odometry", 100)),
        diagnostics_(node.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 100)),
        world_(own.param<std::string>("world_frame", "world")),
        body_(own.param<std::string>("body_frame", "body")) {
    if (own.param("publish_tf", true)) {
      tf_ = node.advertise<tf2_msgs::TFMessage>("/tf", 100);
    }
  }

  void odometry(const limber_node::Odometry& odometry) override {
    nav_msgs::Odometry message;
    message.header.stamp = to_ros(odometry.t_ns);
    message.header.frame_id = world_;
    message.child_frame_id = body_;
    set(message.pose.pose.position, odometry.position);
    auto& q = message.pose.pose.orientation;
    q.x = odometry.orientation[0];
    q.y = odometry.orientation[1];
    q.z = odometry.orientation[2];
    q.w = odometry.orientation[3];
    std::copy(odometry.covariance.begin(), odometry.covariance.end(), message.pose.covariance.begin());
    set(message.twist.twist.linear, odometry.velocity);
    odometry_.publish(message);
    if (tf_) {
      tf2_msgs::TFMessage transforms;
      transforms.transforms.resize(1);
      transforms.transforms[0].header = message.header;
      transforms.transforms[0].child_frame_id = body_;
      set(transforms.transforms[0].transform.translation, odometry.position);
      transforms.transforms[0].transform.rotation = q;
      tf_.publish(transforms);
    }
  }

  void status(const limber_node::Status& status) override {
    diagnostic_msgs::DiagnosticArray message;
    message.header.stamp = to_ros(status.t_ns);
    message.status.resize(1);
    message.status[0].level = static_cast<std::int8_t>(status.level);
    message.status[0].name = status.name;
    message.status[0].message = status.message;
    for (const auto& [key, value] : status.values) {
      diagnostic_msgs::KeyValue entry;
      entry.key = key;
      entry.value = value;
      message.status[0].values.push_back(entry);
    }
    diagnostics_.publish(message);
  }

  void note(const std::string& text) override { ROS_INFO_STREAM(text); }
  void warning(const std::string& text) override { ROS_WARN_STREAM(text); }

 private:
  ros::Publisher odometry_, diagnostics_, tf_;
  std::string world_, body_;
};

/// Hands messages to the core.
class Subscriber {
 public:
  Subscriber(ros::NodeHandle& node, const ros::NodeHandle& own, limber_node::Core& core) : core_(core) {
    subscribe_to_inputs(node, own.param<std::string>("inputs", "imu"));
    const bool compressed = own.param("compressed", false);
    for (const std::size_t camera : {0, 1}) {
      const std::string topic = camera == 0 ? "left/image_raw" : "right/image_raw";
      if (compressed) {
        images_[camera] = node.subscribe<sensor_msgs::CompressedImage>(
            topic + "/compressed", kMostMessages,
            [this, camera](const sensor_msgs::CompressedImageConstPtr& m) { take_file(camera, *m); });
      } else {
        images_[camera] = node.subscribe<sensor_msgs::Image>(
            topic, kMostMessages,
            [this, camera](const sensor_msgs::ImageConstPtr& m) { take_image(camera, *m); });
      }
    }
  }

 private:
  void subscribe_to_inputs(ros::NodeHandle& node, const std::string& inputs) {
    if (inputs == "imu") {
      inputs_ = node.subscribe("imu", kMostMessages, &Subscriber::take_imu, this);
    } else if (inputs == "twist") {
      inputs_ = node.subscribe<geometry_msgs::TwistStamped>(
          "twist_in", kMostMessages,
          [this](const geometry_msgs::TwistStampedConstPtr& m) { take_twist(m->header.stamp, m->twist); });
    } else if (inputs == "twist_with_covariance") {
      inputs_ = node.subscribe<geometry_msgs::TwistWithCovarianceStamped>(
          "twist_in", kMostMessages, [this](const geometry_msgs::TwistWithCovarianceStampedConstPtr& m) {
            take_twist(m->header.stamp, m->twist.twist);
          });
    } else {
      inputs_ = node.subscribe<nav_msgs::Odometry>(
          "odometry_in", kMostMessages,
          [this](const nav_msgs::OdometryConstPtr& m) { take_twist(m->header.stamp, m->twist.twist); });
    }
  }

  void take_twist(const ros::Time& stamp, const geometry_msgs::Twist& twist) {
    const auto &v = twist.linear, &rate = twist.angular;
    core_.add_odometry(from_ros(stamp), {v.x, v.y, v.z}, {rate.x, rate.y, rate.z});
  }

  void take_imu(const sensor_msgs::ImuConstPtr& message) {
    const auto &rate = message->angular_velocity, &force = message->linear_acceleration;
    if (message->angular_velocity_covariance[0] == -1.0 ||
        message->linear_acceleration_covariance[0] == -1.0) {
      ROS_WARN_THROTTLE(10.0,
                        "IMU messages without rates or without accelerations are left out: a driver that "
                        "sends them on two topics must be told to unite them");
      return;
    }
    core_.add_imu(from_ros(message->header.stamp), {rate.x, rate.y, rate.z}, {force.x, force.y, force.z});
  }

  void take_image(std::size_t camera, const sensor_msgs::Image& message) {
    core_.add_image(camera, from_ros(message.header.stamp),
                    {message.encoding, static_cast<int>(message.width), static_cast<int>(message.height),
                     message.step, message.is_bigendian != 0, message.data});
  }

  void take_file(std::size_t camera, const sensor_msgs::CompressedImage& message) {
    limber_node::Image image;
    image.data = message.data;
    core_.add_image(camera, from_ros(message.header.stamp), std::move(image));
  }

  limber_node::Core& core_;
  ros::Subscriber inputs_;
  std::array<ros::Subscriber, 2> images_;
};

limber_node::Parameters parameters_of(const ros::NodeHandle& own) {
  limber_node::Parameters out;
  own.param("calib", out.calib, out.calib);
  own.param("imu_noise", out.imu_noise, out.imu_noise);
  own.param("images", out.images, out.images);
  own.param("inputs", out.inputs, out.inputs);
  own.param("method", out.method, out.method);
  own.param("tolerance", out.tolerance, out.tolerance);
  own.param("max_tracks", out.max_tracks, out.max_tracks);
  own.param("pair_within", out.pair_within, out.pair_within);
  own.param("bits", out.bits, out.bits);
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "limber");
  ros::NodeHandle node, own("~");
  try {
    Publisher publisher(node, own);
    limber_node::Core core(parameters_of(own), publisher);
    const Subscriber subscriber(node, own, core);
    ROS_INFO("waiting for images and inputs");
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
