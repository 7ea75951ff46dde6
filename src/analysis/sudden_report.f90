!> What is told of exact beams whose functions do not follow sudden or fast loads: of the deflection, and of the bending moments, shear
!> forces and reactions that channels ask for. Floor: analysis. Source: doc/theory, eqs. (Q3) to (Q6).
module limber_analysis_sudden_report
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_analysis_function_watch, only: function_watch_type, beam_watch_type
   use limber_analysis_noise, only: noise_of
   use limber_analysis_sudden_watch, only: lost_deflection, lost_moments, lost_shears
   use limber_model_quantities, only: quantity_bending_moment, quantity_stress_top, quantity_stress_bottom, &
      & quantity_shear_force, quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2, quantity_moment, &
      & quantity_torque, quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_ax, quantity_ay, quantity_deflection, &
      & quantity_u1, quantity_u2, quantity_rotation
   use limber_model_scene, only: model_type, quantity_type
   implicit none
   private
   public :: sudden_warnings

   !> Largest error of deflections, and of moments and forces, that is not told; part of the largest force below which one is none; error from which
   !> it is only a bound; what recommended functions are to leave, and most of these
   real(wp), parameter :: little = 5.0e-3_wp, little_force(2) = [1.2e-2_wp, 1.5e-2_wp], nothing = 1.0e-4_wp, all_of_it = 1.0_wp
   real(wp), parameter :: aim = 2.0e-2_wp
   integer, parameter :: most_functions = 40
   !> What is asked of the deflection of a beam
   integer, parameter :: placed(*) = [quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_ax, quantity_ay, &
      & quantity_deflection, quantity_u1, quantity_u2, quantity_rotation]
   !> What is told of
   integer, parameter :: of_moments = 1, of_forces = 2

contains

   !> A warning for each beam.
   function sudden_warnings(self, model, times) result(text)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      !> How many times beyond its limit an error must be
      real(wp), intent(in) :: times
      character(:), allocatable :: text, what, name
      real(wp) :: part, forces(2), most, moved, length
      integer :: i, k, first
      text = ''
      name = ''
      i = 0
      do
         first = i + 1
         if (first > size(self%beams)) exit
         i = last_piece(self, model, first)
         moved = maxval(self%beams(first:i)%moved)*(i - first + 1)
         length = sum([(model%bodies(self%beams(k)%body)%reduced%exact%total, k=first, i)])
         ! What is left then is the integrator's
         if (moved <= noise_of(model%dynamics%tolerance)*length) cycle
         part = 0.0_wp
         forces = 0.0_wp
         do k = first, i
            part = max(part, lost_deflection(self%beams(k)%sudden))
            forces = max(forces, lost_of_channels(self%beams(k), model))
         end do
         part = part/moved
         if (.not. shows_place(model, self%beams(first:i)%body)) part = 0.0_wp
         what = ''
         most = 0.0_wp
         if (part > times*little) call add(part, 'its largest deflection')
         if (forces(of_moments) > times*little_force(of_moments)) call add(forces(of_moments), 'bending moments asked for')
         if (forces(of_forces) > times*little_force(of_forces)) call add(forces(of_forces), 'shear forces and reactions asked for')
         if (what == '') cycle
         associate (body => model%bodies(self%beams(first)%body))
            name = body%name
            if (body%whole > 0) name = model%wholes(body%whole)%name
            text = text//"warning: beam '"//name//"' vibrates under sudden or fast loads in ways that its "// &
               & as_text(body%choice%exact%angles)//' functions of the angle do not follow: '//what//' may be off; '//remedy(most, &
               & body%choice%exact%angles)//newline
         end associate
      end do

   contains

      subroutine add(error, name)
         real(wp), intent(in) :: error
         character(*), intent(in) :: name
         if (what /= '') what = what//', '
         if (error > all_of_it) then
            what = what//'100 % or more of '//name
         else
            what = what//'about '//as_text(100*error, 2)//' % of '//name
         end if
         most = max(most, error)
      end subroutine add

   end function sudden_warnings

   !> Whether a channel asks for anything of a point on bodies.
   pure logical function shows_place(model, bodies)
      type(model_type), intent(in) :: model
      integer, intent(in) :: bodies(:)
      integer :: i, k
      shows_place = .false.
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            associate (quantity => model%channels(i)%quantities(k))
               if (.not. any(quantity%kind == placed)) cycle
               shows_place = shows_place .or. any(model%points(quantity%of)%body == bodies)
            end associate
         end do
      end do
   end function shows_place

   !> The last piece of a beam, whose first one is given; the pieces of a beam are told of as one.
   pure integer function last_piece(self, model, first) result(last)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      integer, intent(in) :: first
      last = first
      associate (whole => model%bodies(self%beams(first)%body)%whole)
         do while (whole > 0 .and. last < size(self%beams))
            if (model%bodies(self%beams(last + 1)%body)%whole /= whole) exit
            last = last + 1
         end do
      end associate
   end function last_piece

   !> What to do: errors of forces fall about as one over the number of functions.
   function remedy(error, functions) result(text)
      real(wp), intent(in) :: error
      integer, intent(in) :: functions
      character(:), allocatable :: text
      integer :: better
      better = nint(functions*max(2.0_wp, error/aim))
      text = 'use FUNCTIONS='//as_text(max(2*functions, min(better, most_functions)))
      if (better > most_functions) text = text//', or let the loads change more slowly'
   end function remedy

   !> Parts of the bending moments and of the shear forces and reactions that channels ask of a beam, that are off (2).
   function lost_of_channels(beam, model) result(lost)
      type(beam_watch_type), intent(in) :: beam
      type(model_type), intent(in) :: model
      real(wp) :: lost(2)
      real(wp), allocatable :: moments(:), shears(:)
      integer :: i, k
      allocate (moments, source=lost_moments(beam%sudden))
      allocate (shears, source=lost_shears(beam%sudden))
      lost = 0.0_wp
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            call judge(model%channels(i)%quantities(k))
         end do
      end do
      if (.not. model%bodies(beam%body)%envelope) return
      do i = 1, size(moments)
         call raise_moment(i)
         call raise_force(i, beam%sudden%sheared)
      end do

   contains

      !> Takes in what a channel asks.
      subroutine judge(quantity)
         type(quantity_type), intent(in) :: quantity
         integer :: side
         if (quantity%of_load .or. quantity%of_coupler) return
         select case (quantity%kind)
         case (quantity_bending_moment, quantity_stress_top, quantity_stress_bottom)
            call at_point(quantity%of, .true., .false., .false.)
         case (quantity_shear_force)
            call at_point(quantity%of, .false., .true., .false.)
         case (quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2)
            if (quantity%of > size(model%joints)) return
            do side = 1, 2
               call at_point(model%joints(quantity%of)%points(side), .false., .false., .true.)
            end do
         case (quantity_moment)
            if (quantity%of > size(model%joints)) return
            do side = 1, 2
               call at_point(model%joints(quantity%of)%points(side), .true., .false., .false.)
            end do
         case (quantity_torque)
            if (quantity%of > size(model%drivers)) return
            if (model%drivers(quantity%of)%body == beam%body) &
               & call raise_moment(station_at(model%bodies(beam%body)%choice%exact%origin))
         end select
      end subroutine judge

      !> At a point of the beam.
      subroutine at_point(point, moment, shear, force)
         integer, intent(in) :: point
         logical, intent(in) :: moment, shear, force
         integer :: at
         if (point == 0) return
         if (model%points(point)%body /= beam%body) return
         at = station_at(model%points(point)%p0(1) + model%bodies(beam%body)%choice%exact%origin)
         if (moment) call raise_moment(at)
         if (shear) call raise_force(at, beam%sudden%sheared)
         if (force) call raise_force(at, beam%sudden%pushed)
      end subroutine at_point

      !> The station nearest to a coordinate along the beam.
      pure integer function station_at(x)
         real(wp), intent(in) :: x
         station_at = minloc(abs(model%bodies(beam%body)%reduced%exact%s - x), dim=1)
      end function station_at

      subroutine raise_moment(at)
         integer, intent(in) :: at
         if (.not. beam%sudden%bent(at) > nothing*maxval(beam%sudden%bent)) return
         lost(of_moments) = max(lost(of_moments), moments(at)/beam%sudden%bent(at))
      end subroutine raise_moment

      subroutine raise_force(at, largest)
         integer, intent(in) :: at
         !> (stations)
         real(wp), intent(in) :: largest(:)
         if (.not. largest(at) > nothing*maxval(largest)) return
         lost(of_forces) = max(lost(of_forces), shears(at)/largest(at))
      end subroutine raise_force

   end function lost_of_channels

end module limber_analysis_sudden_report
