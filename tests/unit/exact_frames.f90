!> An exact theory of plane frames that vibrate: members whose deflections are sines and hyperbolic functions, joined at corners.
!> What frames of finite elements are compared with.
module exact_frames
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: dsyev
   use limber_beam_plane_frame, only: member_type
   implicit none
   private
   public :: dynamic_stiffness, frame_stiffness, exact_near, solved

contains

   !> Stiffness of a member that vibrates at a frequency, in the fixed axes: exact for the partial differential equations.
   function dynamic_stiffness(member, corners, omega) result(k)
      type(member_type), intent(in) :: member
      real(wp), intent(in) :: corners(:, :), omega
      real(wp) :: k(6, 6)
      real(wp) :: l, b, g, c, s, ch, sh, d, line(2), turn(6, 6), own(6, 6), f
      integer :: i, j
      line = corners(:, member%ends(2)) - corners(:, member%ends(1))
      l = norm2(line)
      line = line/l
      own = 0.0_wp
      g = omega*sqrt(member%rho_a/member%ea)
      own([1, 4], [1, 4]) = reshape([cos(g*l), -1.0_wp, -1.0_wp, cos(g*l)], [2, 2])*member%ea*g/sin(g*l)
      b = sqrt(omega*sqrt(member%rho_a/member%ei))
      c = cos(b*l)
      s = sin(b*l)
      ch = cosh(b*l)
      sh = sinh(b*l)
      d = 1 - c*ch
      f = member%ei*b
      own(2, 2) = f*b**2*(c*sh + s*ch)/d
      own(2, 3) = f*b*s*sh/d
      own(2, 5) = -f*b**2*(s + sh)/d
      own(2, 6) = f*b*(ch - c)/d
      own(3, 3) = f*(s*ch - c*sh)/d
      own(3, 5) = -own(2, 6)
      own(3, 6) = f*(sh - s)/d
      own(5, 5) = own(2, 2)
      own(5, 6) = -own(2, 3)
      own(6, 6) = own(3, 3)
      do j = 1, 6
         do i = j + 1, 6
            if (j /= 1 .and. j /= 4 .and. i /= 4) own(i, j) = own(j, i)
         end do
      end do
      turn = 0.0_wp
      turn(1, 1:2) = line
      turn(2, 1:2) = [-line(2), line(1)]
      turn(3, 3) = 1.0_wp
      turn(4:6, 4:6) = turn(1:3, 1:3)
      own = matmul(own, turn)
      k = matmul(transpose(turn), own)
   end function dynamic_stiffness

   !> Number of negative eigenvalues of the dynamic stiffness of the free corners, with masses at them.
   integer function negative(corners, members, mass, free, omega)
      real(wp), intent(in) :: corners(:, :), mass(:, :), omega
      type(member_type), intent(in) :: members(:)
      logical, intent(in) :: free(:, :)
      real(wp) :: part(count(free), count(free)), value(count(free)), work(20*count(free))
      integer :: info
      part = frame_stiffness(corners, members, mass, free, omega)
      call dsyev('N', 'L', size(value), part, size(value), value, work, size(work), info)
      negative = count(value < 0.0_wp)
   end function negative

   !> Dynamic stiffness of the free corners.
   function frame_stiffness(corners, members, mass, free, omega) result(part)
      real(wp), intent(in) :: corners(:, :), mass(:, :), omega
      type(member_type), intent(in) :: members(:)
      logical, intent(in) :: free(:, :)
      real(wp) :: part(count(free), count(free)), whole(3*size(corners, 2), 3*size(corners, 2))
      integer :: m, at(6), i, list(count(free))
      whole = 0.0_wp
      do m = 1, size(members)
         at = [3*members(m)%ends(1) + [-2, -1, 0], 3*members(m)%ends(2) + [-2, -1, 0]]
         whole(at, at) = whole(at, at) + dynamic_stiffness(members(m), corners, omega)
      end do
      do i = 1, size(corners, 2)
         whole(3*i - 2, 3*i - 2) = whole(3*i - 2, 3*i - 2) - omega**2*mass(1, i)
         whole(3*i - 1, 3*i - 1) = whole(3*i - 1, 3*i - 1) - omega**2*mass(2, i)
         whole(3*i, 3*i) = whole(3*i, 3*i) - omega**2*mass(3, i)
      end do
      list = pack([(i, i=1, 3*size(corners, 2))], reshape(free, [3*size(corners, 2)]))
      part = whole(list, list)
   end function frame_stiffness

   !> The exact frequency near a given one, where the number of negative eigenvalues changes; 0: there is none within 2 %.
   real(wp) function exact_near(corners, members, mass, free, guess) result(omega)
      real(wp), intent(in) :: corners(:, :), mass(:, :), guess
      type(member_type), intent(in) :: members(:)
      logical, intent(in) :: free(:, :)
      real(wp) :: low, high
      integer :: below, round
      low = 0.98_wp*guess
      high = 1.02_wp*guess
      below = negative(corners, members, mass, free, low)
      omega = 0.0_wp
      if (negative(corners, members, mass, free, high) == below) return
      do round = 1, 60
         omega = 0.5_wp*(low + high)
         if (negative(corners, members, mass, free, omega) == below) then
            low = omega
         else
            high = omega
         end if
      end do
   end function exact_near

   !> Solution of a small symmetric system by elimination.
   pure function solved(matrix, right) result(x)
      real(wp), intent(in) :: matrix(:, :), right(:)
      real(wp) :: x(size(right)), a(size(right), size(right))
      integer :: i, j
      a = matrix
      x = right
      do i = 1, size(x)
         do j = i + 1, size(x)
            x(j) = x(j) - a(j, i)/a(i, i)*x(i)
            a(j, :) = a(j, :) - a(j, i)/a(i, i)*a(i, :)
         end do
      end do
      do i = size(x), 1, -1
         x(i) = (x(i) - dot_product(a(i, i + 1:), x(i + 1:)))/a(i, i)
      end do
   end function solved

end module exact_frames
