// A stand-in for the library AccelStepper, for tests: the calls that translated sketches use, and what they promise.
//
// Written from the description of the calls, without the library's code.  It steps from the main loop by micros(), as the
// library does, with a constant acceleration from standstill; it knows the interface DRIVER alone: a pin for STEP and one
// for DIR, which is high clockwise, that is where positions grow.
#pragma once

#include <Arduino.h>

class AccelStepper {
 public:
  enum MotorInterfaceType { DRIVER = 1 };

  AccelStepper(uint8_t, uint8_t step, uint8_t dir) : step_(step), dir_(dir) {
    pinMode(step_, OUTPUT);
    pinMode(dir_, OUTPUT);
  }
  void setPinsInverted(bool dir, bool step, bool) { dirInverted_ = dir, stepInverted_ = step; }
  void setMinPulseWidth(unsigned int us) { width_ = us; }
  void setMaxSpeed(float speed) { maxSpeed_ = speed; }
  void setAcceleration(float acceleration) { acceleration_ = acceleration; }
  long currentPosition() { return position_; }
  long targetPosition() { return target_; }
  long distanceToGo() { return target_ - position_; }
  float speed() { return speed_; }
  void setCurrentPosition(long position) { position_ = target_ = position, speed_ = 0; }
  void moveTo(long absolute) { target_ = absolute; }
  void move(long relative) { target_ = position_ + relative; }

  /** Set a target that is as near as the acceleration allows. */
  void stop() {
    long steps = speed_ * speed_ / (2 * acceleration_) + 1;
    if (speed_ > 0) move(steps);
    if (speed_ < 0) move(-steps);
  }

  /** Make a step if one is due; return whether it is on its way still. */
  bool run() {
    if (speed_ == 0) {
      if (distanceToGo() == 0) return false;
      begin();
    }
    if (micros() - last_ < interval_) return true;
    last_ = micros();
    pulse(speed_ > 0);
    next();
    return speed_ != 0;
  }
  void runToPosition() { while (run()) {} }

  void setSpeed(float speed) {
    speed = constrain(speed, -maxSpeed_, maxSpeed_);
    speed_ = speed;
    interval_ = speed == 0 ? 0 : 1e6 / fabs(speed);
  }
  /** Make a step towards the target if one is due, at the speed that was set. */
  bool runSpeedToPosition() {
    if (distanceToGo() == 0) return false;
    if ((distanceToGo() > 0) != (speed_ > 0)) speed_ = -speed_;
    return runSpeed();
  }
  bool runSpeed() {
    if (speed_ == 0 || micros() - last_ < interval_) return false;
    last_ = micros();
    pulse(speed_ > 0);
    return true;
  }

 private:
  void begin() {
    setSpeed((distanceToGo() > 0 ? 1 : -1) * min(sqrt(acceleration_ / 2), maxSpeed_));
    last_ = micros();
  }
  /** Find the speed up to the next step: v * v = 2 * a * s, up the ramp, down it, or the greatest. */
  void next() {
    bool up = speed_ > 0;
    long left = up ? distanceToGo() : -distanceToGo();
    float square = speed_ * speed_;
    if (left <= 0 && square <= 3 * acceleration_) return setSpeed(0);
    float grown = square + 2 * acceleration_, most = 2 * acceleration_ * (left > 0 ? left : 0.25f);
    float next = sqrt(left <= 0 ? max(square - 2 * acceleration_, 0.5f * acceleration_) : min(grown, most));
    if (next > maxSpeed_) next = maxSpeed_;
    setSpeed(up ? next : -next);
  }
  void pulse(bool up) {
    position_ += up ? 1 : -1;
    digitalWrite(dir_, up != dirInverted_);
    digitalWrite(step_, !stepInverted_);
    delayMicroseconds(width_);
    digitalWrite(step_, stepInverted_);
  }

  uint8_t step_, dir_;
  bool dirInverted_ = false, stepInverted_ = false;
  unsigned int width_ = 1;
  float maxSpeed_ = 1, acceleration_ = 1, speed_ = 0;
  long position_ = 0, target_ = 0;
  unsigned long last_ = 0, interval_ = 0;
};
