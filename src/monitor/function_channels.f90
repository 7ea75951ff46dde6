!> Channels of exact beams that their monitors serve. Displacements along it, places, bending moments, shear forces and reactions,
!> those of bodies that joints connect with it among them; and the parts of these that sudden or fast loads make wrong. Floor:
!> monitor. Source: doc/theory, eqs. (7.58)-(7.62), (7.65).
module limber_monitor_function_channels
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: exact_type
   use limber_monitor_connections, only: ends_of, hangs_on, connected_with
   use limber_monitor_function_sudden, only: lost_moments, lost_shears, lost_pulls
   use limber_monitor_function_watch, only: function_watch_type, beam_watch_type, station_of
   use limber_model_quantities, only: quantity_bending_moment, quantity_stress_top, quantity_stress_bottom, &
      & quantity_shear_force, quantity_axial_force, quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2, &
      & quantity_moment, quantity_torque, quantity_force, quantity_power, quantity_x, quantity_y, quantity_vx, quantity_vy, &
      & quantity_ax, quantity_ay, quantity_deflection, quantity_u1, quantity_u2, quantity_rotation
   use limber_model_model, only: model_type, quantity_type, driver_distance, along_distance, ground
   implicit none
   private
   public :: asks_along, shows_place, asks_moment, lost_of_channels, lost_along, of_moments, of_forces, of_pulls

   !> Kinds of what errs
   integer, parameter :: of_moments = 1, of_forces = 2, of_pulls = 3
   !> Part of the largest force below which one is none
   real(wp), parameter :: nothing = 1.0e-4_wp
   !> What is asked of the deflection of a beam
   integer, parameter :: placed(*) = [quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_ax, quantity_ay, &
      & quantity_deflection, quantity_u1, quantity_u2, quantity_rotation]
   !> Of its bending moments
   integer, parameter :: bent(*) = [quantity_bending_moment, quantity_stress_top, quantity_stress_bottom]

contains

   !> Whether a channel asks for displacements along a beam, those of a frame being told in the axes of the frame, or the distance
   !> of two of its points decides on a force.
   pure logical function asks_along(model, whole, bodies)
      type(model_type), intent(in) :: model
      !> What the pieces of the beam belong to, 0 if it is in one; its bodies
      integer, intent(in) :: whole, bodies(:)
      integer :: i, k
      asks_along = .false.
      if (whole > 0) then
         if (allocated(model%wholes(whole)%lean)) return
      end if
      do i = 1, size(model%channels)
         associate (quantities => model%channels(i)%quantities)
            do k = 1, size(quantities)
               if (quantities(k)%kind /= quantity_u1) cycle
               asks_along = asks_along .or. any(model%points(quantities(k)%of)%body == bodies)
            end do
         end associate
      end do
      do i = 1, size(model%drivers)
         if (model%drivers(i)%kind == driver_distance) asks_along = asks_along .or. are_within(model%drivers(i)%points)
      end do
      do i = 1, size(model%load_parts)
         associate (part => model%load_parts(i))
            if (part%along /= along_distance .or. .not. part%stiffness > 0.0_wp) cycle
            asks_along = asks_along .or. are_within(part%points)
         end associate
      end do

   contains

      pure logical function are_within(points)
         integer, intent(in) :: points(2)
         integer :: of(2)
         are_within = .false.
         if (any(points == 0)) return
         of = model%points(points)%body
         are_within = any(bodies == of(1)) .and. any(bodies == of(2))
      end function are_within

   end function asks_along

   !> Whether a channel asks for anything of a point on bodies, or on what hangs on them alone.
   pure logical function shows_place(model, bodies)
      type(model_type), intent(in) :: model
      integer, intent(in) :: bodies(:)
      integer :: i, k, body
      shows_place = .false.
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            associate (quantity => model%channels(i)%quantities(k))
               if (.not. any(quantity%kind == placed)) cycle
               body = model%points(quantity%of)%body
               shows_place = shows_place .or. any(body == bodies) .or. hangs_on(model, body, bodies)
            end associate
         end do
      end do
   end function shows_place

   !> Whether a channel asks for bending moments, stresses or moments of joints of bodies.
   pure logical function asks_moment(model, bodies)
      type(model_type), intent(in) :: model
      integer, intent(in) :: bodies(:)
      integer :: i, k, ends(2)
      asks_moment = any(model%bodies(bodies)%envelope)
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            associate (quantity => model%channels(i)%quantities(k))
               ends = ground
               if (any(quantity%kind == bent)) ends = model%points(quantity%of)%body
               if (quantity%kind == quantity_moment .and. .not. (quantity%of_load .or. quantity%of_coupler) .and. &
                  & quantity%of <= size(model%joints)) ends = ends_of(model, quantity%of)
               asks_moment = asks_moment .or. any(ends(1) == bodies) .or. any(ends(2) == bodies)
            end associate
         end do
      end do
   end function asks_moment

   !> Largest part of the forces along beams that is off, of those that channels ask for.
   real(wp) function lost_along(self, model) result(part)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      real(wp) :: lost(3)
      integer :: k
      part = 0.0_wp
      do k = 1, size(self%beams)
         lost = lost_of_channels(self, self%beams(k), model)
         part = max(part, lost(of_pulls))
      end do
   end function lost_along

   !> Parts of the bending moments, of forces across the beam and of forces along it that are off (3), of those that channels ask of
   !> it, and of reactions and efforts of drivers of bodies that joints connect with it, eqs. (7.62), (7.65).
   function lost_of_channels(self, beam, model) result(lost)
      type(function_watch_type), intent(in) :: self
      type(beam_watch_type), intent(in) :: beam
      type(model_type), intent(in) :: model
      real(wp) :: lost(3)
      real(wp), allocatable :: moments(:), shears(:), pulls(:)
      logical :: reached(0:size(model%bodies))
      real(wp) :: passed(3)
      integer :: i, k
      allocate (moments, source=lost_moments(beam%sudden))
      allocate (shears, source=lost_shears(beam%sudden))
      allocate (pulls, source=lost_pulls(beam%sudden))
      lost = 0.0_wp
      reached = connected_with(model, beam%body)
      passed = passed_on()
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            call judge(model%channels(i)%quantities(k))
         end do
      end do
      if (.not. model%bodies(beam%body)%envelope) return
      do i = 1, size(moments)
         call raise_moment(i)
         call raise_force(of_forces, i, shears, beam%sudden%sheared)
      end do

   contains

      !> What is off of the forces that the beam passes on by its joints, across and along it, and the largest of these (3).
      pure function passed_on() result(force)
         real(wp) :: force(3)
         integer :: i
         force = 0.0_wp
         do i = 1, size(beam%held_at)
            associate (at => beam%held_at(i))
               force = max(force, [shears(at), pulls(at), beam%sudden%pushed(at)])
            end associate
         end do
      end function passed_on

      !> Takes in what a channel asks.
      subroutine judge(quantity)
         type(quantity_type), intent(in) :: quantity
         if (quantity%of_load .or. quantity%of_coupler) return
         select case (quantity%kind)
         case (quantity_bending_moment, quantity_stress_top, quantity_stress_bottom)
            call raise_moment(station_of(model, beam%body, quantity%of))
         case (quantity_shear_force)
            call raise_force(of_forces, station_of(model, beam%body, quantity%of), shears, beam%sudden%sheared)
         case (quantity_axial_force)
            call raise_force(of_pulls, station_of(model, beam%body, quantity%of), pulls, beam%sudden%drawn)
         case (quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2, quantity_moment)
            if (quantity%of > size(model%joints)) return
            if (quantity%kind == quantity_moment) call of_moment(quantity%of)
            if (quantity%kind /= quantity_moment) call of_force(quantity%of, quantity%kind)
         case (quantity_torque, quantity_force, quantity_power)
            if (quantity%of <= size(model%drivers)) call of_driver(quantity%of)
         end select
      end subroutine judge

      !> Component of the force of a joint: of a joint of the beam what is off there, of another one what the beam passes on.
      subroutine of_force(joint, kind)
         integer, intent(in) :: joint, kind
         integer, parameter :: kinds(4) = [quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2]
         integer :: component, which, at(2)
         real(wp) :: off(2), largest
         at = [station_of(model, beam%body, model%joints(joint)%points(1)), station_of(model, beam%body, &
            & model%joints(joint)%points(2))]
         off = passed(:2)
         if (any(at > 0)) off = [shears(maxval(at)), pulls(maxval(at))]
         if (all(at == 0) .and. .not. any(reached(ends_of(model, joint)))) return
         component = maxloc(merge(1, 0, kinds == kind), dim=1)
         do which = 1, size(self%reactions)
            if (self%reactions(which)%joint /= joint) cycle
            largest = self%reactions(which)%largest(component)
            if (.not. largest > nothing*maxval(beam%sudden%pushed)) cycle
            lost(of_forces:) = max(lost(of_forces:), off*[beam%across(component, which), beam%along(component, which)]/largest)
         end do
      end subroutine of_force

      !> Moment of a joint.
      subroutine of_moment(joint)
         integer, intent(in) :: joint
         integer :: side, at
         logical :: own
         own = .false.
         do side = 1, 2
            at = station_of(model, beam%body, model%joints(joint)%points(side))
            own = own .or. at > 0
            call raise_moment(at)
         end do
         if (.not. own .and. any(reached(ends_of(model, joint)))) call raise_passed()
      end subroutine of_moment

      !> Torque, force or power of a driver, of which forces that are passed on are a part by their lever, eq. (7.63).
      subroutine of_driver(driver)
         integer, intent(in) :: driver
         integer :: side
         associate (own => model%drivers(driver))
            if (own%body == beam%body) then
               associate (body => model%bodies(beam%body))
                  call raise_moment(minloc(abs(body%reduced%exact%s - body%choice%exact%origin), dim=1))
               end associate
            else if (own%body > 0) then
               if (reached(own%body)) call raise_driven(driver)
            else if (own%joint > 0) then
               if (any(reached(ends_of(model, own%joint)))) call raise_driven(driver)
            else
               do side = 1, 2
                  if (own%points(side) == 0) cycle
                  if (reached(model%points(own%points(side))%body)) call raise_driven(driver)
               end do
            end if
         end associate
      end subroutine of_driver

      subroutine raise_driven(driver)
         integer, intent(in) :: driver
         integer :: which
         do which = 1, size(self%driven)
            associate (of => self%driven(which))
               if (of%driver /= driver .or. .not. of%largest > nothing*of%lever*passed(3)) cycle
               lost(of_forces:) = max(lost(of_forces:), passed(:2)*of%lever/of%largest*beam%drawn_by(:, which))
            end associate
         end do
      end subroutine raise_driven

      subroutine raise_moment(at)
         integer, intent(in) :: at
         if (at == 0) return
         if (.not. beam%sudden%bent(at) > nothing*maxval(beam%sudden%bent)) return
         if (ends_at_zero(model%bodies(beam%body)%reduced%exact, at, beam%sudden%bent)) return
         lost(of_moments) = max(lost(of_moments), moments(at)/beam%sudden%bent(at))
      end subroutine raise_moment

      subroutine raise_force(kind, at, off, largest)
         integer, intent(in) :: kind, at
         !> (stations)
         real(wp), intent(in) :: off(:), largest(:)
         if (at == 0) return
         if (.not. largest(at) > nothing*maxval(largest)) return
         if (ends_at_zero(model%bodies(beam%body)%reduced%exact, at, largest)) return
         lost(kind) = max(lost(kind), off(at)/largest(at))
      end subroutine raise_force

      !> What is off of the forces that are passed on.
      subroutine raise_passed()
         if (passed(3) > 0.0_wp) lost(of_forces:) = max(lost(of_forces:), passed(:2)/passed(3))
      end subroutine raise_passed

   end function lost_of_channels

   !> Whether a section force goes to zero from the station nearest to an end of a beam to that end, as at a hinge or a free end:
   !> the value there is zero by equilibrium, that of the station says nothing on it.
   pure logical function ends_at_zero(exact, at, largest)
      type(exact_type), intent(in) :: exact
      !> Index of the station
      integer, intent(in) :: at
      !> Largest magnitudes (stations)
      real(wp), intent(in) :: largest(:)
      !> Part of the value at the station
      real(wp), parameter :: little = 0.3_wp
      real(wp) :: end
      integer :: next
      ends_at_zero = .false.
      if (size(largest) < 2 .or. (at > 1 .and. at < size(largest))) return
      next = merge(2, size(largest) - 1, at == 1)
      end = merge(0.0_wp, exact%total, at == 1)
      associate (slope => (largest(next) - largest(at))/(exact%s(next) - exact%s(at)))
         ends_at_zero = abs(largest(at) + slope*(end - exact%s(at))) < little*largest(at)
      end associate
   end function ends_at_zero

end module limber_monitor_function_channels
