!> Quasi-static deflection of a beam that the model takes for rigid. Deflection, Euler's load and first frequency in closed form,
!> from its rigidity and mass alone. Floor: beam. Source: doc/theory, eqs. (7.32)-(7.35).
!>
!>     beam = new_quasistatic(ei, rho_a, length, origin, place, jointed, clamped)
!>     call find_deflection(beam, along, across, omega, alpha, force, deflection, seen, axial)
module limber_beam_quasistatic_deflection
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: quasistatic_type, new_quasistatic, find_deflection

   !> Pieces of the integral along the beam, of equal length
   integer, parameter :: pieces = 32
   real(wp), parameter :: pi = acos(-1.0_wp)

   !> The constants of one beam
   type :: quasistatic_type
      !> Bending rigidity [force length^2], mass per length, length, coordinate along the beam where its frame begins [length]
      real(wp) :: ei = 1.0_wp, rho_a = 1.0_wp, length = 1.0_wp, origin = 0.0_wp
      !> Coordinates along the beam of the places where forces act [length]
      real(wp), allocatable :: place(:)
      !> Deflections are those from the tangent at `from`, if the beam is held there alone and cannot turn, else from the line
      !> through `from` and `to` [length]
      logical :: clamped = .false.
      real(wp) :: from = 0.0_wp, to = 1.0_wp
      !> First frequency of bending [1/time], Euler's load [force], as its joints hold it
      real(wp) :: frequency = 0.0_wp, euler = 0.0_wp
   end type quasistatic_type

contains

   !> Constants of a beam: how its joints hold it decides from where deflections count, eqs. (7.34), (7.35).
   pure function new_quasistatic(ei, rho_a, length, origin, place, jointed, clamped) result(self)
      !> As in the type
      real(wp), intent(in) :: ei, rho_a, length, origin
      !> Coordinates along the beam where forces act [length], and whether those are of joints
      real(wp), intent(in) :: place(:)
      logical, intent(in) :: jointed(:)
      !> Whether the only joint, if there is one, or a driver keeps the beam from turning
      logical, intent(in) :: clamped
      type(quasistatic_type) :: self
      !> Squares of the roots of the frequency equations: hinges, clamped and free, hinge and free, free and free
      real(wp), parameter :: hinges = pi**2, cantilever = 3.51602_wp, swinging = 15.41821_wp, flying = 22.37329_wp
      real(wp) :: span, reach
      self%ei = ei
      self%rho_a = rho_a
      self%length = length
      self%origin = origin
      allocate (self%place, source=place)
      self%from = 0.0_wp
      self%to = length
      if (any(jointed)) self%from = minval(place, mask=jointed)
      if (any(jointed)) self%to = maxval(place, mask=jointed)
      span = self%to - self%from
      self%clamped = .not. span > 0.0_wp .and. clamped
      if (self%clamped) then
         reach = max(self%from, length - self%from)
         self%frequency = cantilever*sqrt(ei/rho_a)/reach**2
         self%euler = pi**2*ei/(4*reach**2)
      else if (span > 0.0_wp .and. any(jointed)) then
         self%frequency = hinges*sqrt(ei/rho_a)/span**2
         self%euler = pi**2*ei/span**2
      else
         self%frequency = merge(swinging, flying, any(jointed))*sqrt(ei/rho_a)/length**2
         self%euler = pi**2*ei/length**2
         self%from = 0.0_wp
         self%to = length
      end if
   end function new_quasistatic

   !> Deflection and axial force under what acts on the beam, its inertia included, eqs. (7.32), (7.33).
   subroutine find_deflection(self, along, across, omega, alpha, force, deflection, seen, axial)
      type(quasistatic_type), intent(in) :: self
      !> Acceleration of the frame's origin less that of gravity, along and across the beam; angular velocity and acceleration
      real(wp), intent(in) :: along, across, omega, alpha
      !> Forces along and across the beam and couple at each place (3, places)
      real(wp), intent(in) :: force(:, :)
      !> Largest deflection [length]; those at the start, in the middle, at the end [length]; mean axial force, tension positive
      real(wp), intent(out) :: deflection, seen(3), axial
      real(wp) :: w(0:pieces), slope(0:pieces), rest, couple, h, x, b, moment, line(2)
      integer :: i, k
      h = self%length/pieces
      call find_rest()
      w(0) = 0.0_wp
      slope(0) = 0.0_wp
      axial = 0.0_wp
      do i = 1, pieces
         x = (i - 0.5_wp)*h
         b = self%length - x
         moment = -self%rho_a*(across*b**2/2 + alpha*((x - self%origin)*b**2/2 + b**3/3))
         axial = axial - self%rho_a*(along*b - omega**2*((x - self%origin)*b + b**2/2))/pieces
         do k = 1, size(self%place)
            if (self%place(k) < x) cycle
            moment = moment + force(3, k) + force(2, k)*(self%place(k) - x)
            axial = axial + force(1, k)/pieces
         end do
         if (self%origin > x) moment = moment + couple + rest*(self%origin - x)
         slope(i) = slope(i - 1) + h*moment/self%ei
         w(i) = w(i - 1) + h*slope(i - 1) + h**2/2*moment/self%ei
      end do
      line = [at(w, self%from), at(slope, self%from)]
      if (.not. self%clamped) line(2) = (at(w, self%to) - line(1))/(self%to - self%from)
      do i = 0, pieces
         w(i) = w(i) - line(1) - line(2)*(i*h - self%from)
      end do
      deflection = maxval(abs(w))
      seen = [w(0), w(pieces/2), w(pieces)]

   contains

      !> What is missing of the balance of forces across the beam and of moments acts at the origin of the frame: that of drivers.
      subroutine find_rest()
         integer :: j
         rest = self%rho_a*self%length*(across + alpha*(self%length/2 - self%origin))
         couple = self%rho_a*self%length**2*(across/2 + alpha*(self%length/3 - self%origin/2))
         do j = 1, size(self%place)
            rest = rest - force(2, j)
            couple = couple - force(3, j) - force(2, j)*self%place(j)
         end do
         couple = couple - rest*self%origin
      end subroutine find_rest

      !> Value at a coordinate along the beam.
      pure real(wp) function at(values, place)
         real(wp), intent(in) :: values(0:), place
         integer :: j
         j = min(pieces - 1, max(0, int(place/h)))
         at = values(j) + (values(j + 1) - values(j))*(place/h - j)
      end function at

   end subroutine find_deflection

end module limber_beam_quasistatic_deflection
